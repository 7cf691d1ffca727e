// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/staging_folder.cpp
#include "files/staging_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <mutex>
#include <new>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

constexpr const char *kPrefix = ".dgm-", *kLock = ".lock";
constexpr std::size_t kRandom = 6;
constexpr int kDepth = 8;  ///< of folders in a staging folder

int open_folder(const fs::path& path) {
    return ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
}

/// The lock inside, newly made or as it is there. A negative one has no lock, with errno.
int open_lock(int folder, int flags) {
    return ::openat(folder, kLock, flags | O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
}

void close_if_open(int& descriptor) {
    if (descriptor >= 0) ::close(std::exchange(descriptor, -1));
}

void remove_content(int folder, int depth) noexcept;

/// @param depth  of folders in it that are removed as well
bool remove_folder(int parent, const char* name, int depth) noexcept {
    int folder = depth > 0 ? ::openat(parent, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW) : -1;
    if (folder < 0) return false;
    remove_content(folder, depth - 1);
    close_if_open(folder);
    return ::unlinkat(parent, name, AT_REMOVEDIR) == 0;
}

/// Removes what is in an open folder; the lock last, and only if nothing else is left: what stays is then the next
/// program's to remove. Takes no memory and opens nothing but folders: both may be short.
void remove_content(int folder, int depth) noexcept {
    alignas(dirent64) std::array<char, 4096> entries;
    bool has_removed = true, is_empty = false;
    while (has_removed) {  // a folder may pass over entries while others are removed
        has_removed = false;
        is_empty = true;
        ::lseek(folder, 0, SEEK_SET);
        for (ssize_t size; (size = ::getdents64(folder, entries.data(), entries.size())) > 0;)
            for (ssize_t at = 0; at < size;) {
                const auto* entry = reinterpret_cast<const dirent64*>(&entries[static_cast<std::size_t>(at)]);
                at += entry->d_reclen;
                const std::string_view name = entry->d_name;
                if (name == "." || name == ".." || name == kLock) continue;
                const bool is_gone =
                    ::unlinkat(folder, entry->d_name, 0) == 0 || remove_folder(folder, entry->d_name, depth);
                has_removed |= is_gone;
                is_empty &= is_gone;
            }
    }
    if (is_empty) ::unlinkat(folder, kLock, 0);
}

bool is_staging_name(const fs::path& name) {
    const std::string& text = name.native();
    return text.starts_with(kPrefix) && text.size() == std::strlen(kPrefix) + kRandom &&
           text.find('.', 1) == std::string::npos;
}

/// A folder of ours that nobody else can enter.
bool is_private(const fs::path& folder) {
    struct stat status {};
    return ::lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == ::geteuid() &&
           (status.st_mode & 077) == 0;
}

/// Between making its folder and its lock, a living program has none: only an hour later it must be dead.
bool is_old(const fs::path& folder) {
    std::error_code error;
    const auto written = fs::last_write_time(folder, error);
    return !error && fs::file_time_type::clock::now() - written > std::chrono::hours(1);
}

void remove_if_dead(const fs::path& folder) {
    if (!is_private(folder)) return;
    int opened = open_folder(folder);
    int lock = opened < 0 ? -1 : open_lock(opened, 0);
    const bool is_dead = lock >= 0 ? ::flock(lock, LOCK_EX | LOCK_NB) == 0 : errno == ENOENT && is_old(folder);
    std::error_code ignored;
    if (is_dead) fs::remove_all(folder, ignored);
    close_if_open(lock);
    close_if_open(opened);
}

/// Once a folder and program: a batch makes thousands of staging folders in one.
void clear_once(const fs::path& folder) {
    static std::mutex mutex;
    static std::set<fs::path> cleared;
    {
        const std::scoped_lock lock(mutex);
        std::error_code ignored;
        if (!cleared.insert(fs::absolute(folder, ignored)).second) return;
    }
    remove_dead_staging_folders(folder);
}

}  // namespace

StagingFolder::StagingFolder(const fs::path& output, const char* failed) {
    const fs::path parent = output.has_parent_path() ? output.parent_path() : fs::path(".");
    clear_once(parent);
    const auto fail = [&](int error) {
        throw model::Error(write_failure(error), std::string(failed) + ": " + std::strerror(error), output.string());
    };
    // Another program may take a folder for a dead one until its lock is held; then there is a next one.
    for (int attempt = 0; attempt < 8; ++attempt) {
        std::string name = (parent / kPrefix).native() + std::string(kRandom, 'X');
        if (::mkdtemp(name.data()) == nullptr) fail(errno);
        try {
            path_ = name;
        } catch (const std::bad_alloc&) {
            ::rmdir(name.c_str());
            throw;
        }
        folder_ = open_folder(path_);
        lock_ = folder_ < 0 ? -1 : open_lock(folder_, O_CREAT | O_EXCL);
        const int error = errno;
        struct stat status {};
        if (lock_ >= 0) {
            // A file system without locks has nobody who would remove the folder either.
            const bool is_free = ::flock(lock_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
            if (is_free && ::fstat(lock_, &status) == 0 && status.st_nlink > 0) return;
            close_if_open(lock_);
            close_if_open(folder_);
        } else {
            close_if_open(folder_);
            if (error == ENOENT) continue;
            ::rmdir(path_.c_str());
            fail(error);
        }
    }
    fail(EBUSY);
}

StagingFolder::StagingFolder(StagingFolder&& other) noexcept
    : path_(std::exchange(other.path_, fs::path())),
      folder_(std::exchange(other.folder_, -1)),
      lock_(std::exchange(other.lock_, -1)) {}

StagingFolder& StagingFolder::operator=(StagingFolder&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(folder_, other.folder_);
    std::swap(lock_, other.lock_);
    return *this;
}

StagingFolder::~StagingFolder() {
    if (path_.empty()) return;
    remove_content(folder_, kDepth);
    ::rmdir(path_.c_str());
    close_if_open(lock_);
    close_if_open(folder_);
}

bool is_staging_lock(const fs::path& file) {
    return file.filename() == kLock;
}

void remove_dead_staging_folders(const fs::path& folder) noexcept {
    try {
        std::vector<fs::path> found;
        std::error_code error;
        for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
            if (is_staging_name(it->path().filename())) found.push_back(it->path());
        for (const fs::path& path : found) remove_if_dead(path);
    } catch (const std::exception&) {}  // no memory: the next program finds them
}

}  // namespace dgm::formats
