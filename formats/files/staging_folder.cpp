// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/staging_folder.cpp
#include "files/staging_folder.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <mutex>
#include <new>
#include <set>
#include <string>
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

/// The lock inside, newly made or as it is there. A negative one has no lock, with errno.
int open_lock(const fs::path& folder, int flags) {
    return ::open((folder / kLock).c_str(), flags | O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
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
    const int lock = open_lock(folder, 0);
    const bool is_dead = lock >= 0 ? ::flock(lock, LOCK_EX | LOCK_NB) == 0 : errno == ENOENT && is_old(folder);
    std::error_code ignored;
    if (is_dead) fs::remove_all(folder, ignored);
    if (lock >= 0) ::close(lock);
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

const model::Code& write_failure(int error_number) {
    switch (error_number) {
        case ENOSPC:
        case EDQUOT:
            return codes::kNoSpace;
        case EIO:
        case ESTALE:
        case ETIMEDOUT:
        case EAGAIN:
        case ENFILE:
        case EMFILE:
        case ENOMEM:
            return codes::kIoTrouble;
        default:
            return codes::kWriteFailed;
    }
}

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
        path_ = name;
        lock_file_ = path_ / kLock;
        lock_ = open_lock(path_, O_CREAT | O_EXCL);
        const int error = errno;
        struct stat status {};
        if (lock_ >= 0) {
            // A file system without locks has nobody who would remove the folder either.
            const bool is_free = ::flock(lock_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
            if (is_free && ::fstat(lock_, &status) == 0 && status.st_nlink > 0) return;
            ::close(std::exchange(lock_, -1));
        } else if (error != ENOENT) {
            ::rmdir(path_.c_str());
            fail(error);
        }
    }
    fail(EBUSY);
}

StagingFolder::StagingFolder(StagingFolder&& other) noexcept
    : path_(std::exchange(other.path_, fs::path())),
      lock_file_(std::move(other.lock_file_)),
      lock_(std::exchange(other.lock_, -1)) {}

StagingFolder& StagingFolder::operator=(StagingFolder&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(lock_file_, other.lock_file_);
    std::swap(lock_, other.lock_);
    return *this;
}

StagingFolder::~StagingFolder() {
    if (path_.empty()) return;
    // Nearly always the lock alone is left, and that goes without memory and without opening the folder.
    ::unlink(lock_file_.c_str());
    std::error_code ignored;
    if (::rmdir(path_.c_str()) != 0) try {
            fs::remove_all(path_, ignored);
        } catch (const std::bad_alloc&) {}  // a later program removes it
    if (lock_ >= 0) ::close(lock_);
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
