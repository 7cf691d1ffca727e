// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_stream.cpp
#include "exr/exr_stream.h"

#include <ImfMultiPartInputFile.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "exr/exr_threads.h"
#include "files/staging_folder.h"
#include "model/codes.h"

namespace dgm::formats {

model::Error exr_failure(const std::exception& caught, const std::filesystem::path& path) {
    const auto* system = dynamic_cast<const std::system_error*>(&caught);
    return {system != nullptr ? write_failure(system->code().value()) : model::codes::kWriteFailed,
            std::string("OpenEXR: ") + caught.what(), path.string()};
}

ExrStream::ExrStream(const std::filesystem::path& path)
    : Imf::OStream(path.c_str()), out_(path, std::ios::binary | std::ios::trunc) {
    check();
    make_exr_threads();
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
    const Imf::MultiPartInputFile written(fileName(), 0);
    for (int part = 0; part < written.parts(); ++part)
        if (!written.partComplete(part)) throw std::system_error(ENOMEM, std::generic_category(), "lines are missing");
}

void ExrStream::note() {
    if (error_ == 0 && !out_) error_ = errno != 0 ? errno : EIO;
}

void ExrStream::check() {
    note();
    if (error_ != 0) throw std::system_error(error_, std::generic_category());
}

}  // namespace dgm::formats
