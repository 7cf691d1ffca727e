// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_stream.cpp
#include "exr/exr_stream.h"

#include <cerrno>
#include <system_error>

namespace dgm::formats {

ExrStream::ExrStream(const std::filesystem::path& path)
    : Imf::OStream(path.c_str()), out_(path, std::ios::binary | std::ios::trunc) {
    check();
}

void ExrStream::write(const char bytes[], int count) {
    errno = 0;
    out_.write(bytes, count);
    check();
}

std::uint64_t ExrStream::tellp() {
    const std::streamoff place = out_.tellp();
    return place < 0 ? 0 : static_cast<std::uint64_t>(place);
}

void ExrStream::seekp(std::uint64_t place) {
    errno = 0;
    out_.seekp(static_cast<std::streamoff>(place));
    note();
}

void ExrStream::finish() {
    if (error_ == 0) {
        errno = 0;
        out_.close();
    }
    check();
}

void ExrStream::note() {
    if (error_ == 0 && !out_) error_ = errno != 0 ? errno : EIO;
}

void ExrStream::check() {
    note();
    if (error_ != 0) throw std::system_error(error_, std::generic_category());
}

}  // namespace dgm::formats
