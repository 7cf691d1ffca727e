// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/regular_file.cpp
#include "files/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "files/io_failure.h"
#include "model/codes.h"
#include "model/file_errors.h"

namespace dgm::formats {

RegularFile::RegularFile(const std::filesystem::path& path)
    : path_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)) {
    const int error = errno;
    if (file_ < 0) {
        if (error == ENOENT || error == ENOTDIR) throw model::missing_file(path);
        // A socket, or a device without a driver behind it.
        if (error == ENXIO || error == ENODEV) throw model::no_regular_file(path);
        throw model::unreadable_file(path, std::generic_category().message(error), read_failure(error));
    }
    struct stat status {};
    const int trouble = ::fstat(file_, &status) != 0 ? errno : 0;
    if (trouble != 0 || !S_ISREG(status.st_mode)) {
        ::close(file_);
        if (trouble != 0)
            throw model::unreadable_file(path, std::generic_category().message(trouble), read_failure(trouble));
        throw model::no_regular_file(path);
    }
    size_ = static_cast<std::uint64_t>(status.st_size);
    device_ = static_cast<std::uint64_t>(status.st_dev);
    inode_ = static_cast<std::uint64_t>(status.st_ino);
}

RegularFile::~RegularFile() {
    ::close(file_);
}

std::size_t RegularFile::read(std::span<std::byte> block) {
    std::size_t done = 0;
    while (done < block.size()) {
        const ssize_t got = ::read(file_, block.data() + done, block.size() - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
            throw model::Error(read_failure(errno),
                               "the file cannot be read to its end: " + std::generic_category().message(errno),
                               path_.string());
        if (got == 0) break;
        done += static_cast<std::size_t>(got);
    }
    return done;
}

bool RegularFile::seek(std::uint64_t at) {
    return ::lseek(file_, static_cast<off_t>(at), SEEK_SET) >= 0;
}

void RegularFile::check_size(std::uint64_t max_bytes) const {
    if (size_ > max_bytes)
        throw model::Error(model::codes::kTooLarge,
                           std::to_string(size_) + " bytes; the limit is " + std::to_string(max_bytes), path_.string());
}

std::string RegularFile::read_text(std::uint64_t max_bytes) {
    check_size(max_bytes);
    // Files of /proc have no size: they are read block by block.
    constexpr std::size_t kBlock = 65536;
    std::string text;
    for (std::size_t got = 0, wanted = std::max<std::size_t>(size_, kBlock);; wanted = kBlock) {
        const std::size_t before = text.size();
        text.resize(before + wanted);
        got = read(std::as_writable_bytes(std::span(text)).subspan(before));
        text.resize(before + got);
        if (text.size() > max_bytes)
            throw model::Error(model::codes::kTooLarge, "more than " + std::to_string(max_bytes) + " bytes",
                               path_.string());
        if (got < wanted) return text;
    }
}

std::string read_small_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
    return RegularFile(path).read_text(max_bytes);
}

}  // namespace dgm::formats
