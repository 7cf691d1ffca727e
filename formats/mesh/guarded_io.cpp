// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/guarded_io.cpp
#include "mesh/guarded_io.h"

#include <memory>
#include <string_view>

#include <assimp/IOStream.hpp>

#include "files/io_failure.h"
#include "files/regular_file.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace fs = std::filesystem;

/// assimp takes a short read for the end of the file: the failure behind it is kept beside.
class CheckedStream : public Assimp::IOStream {
 public:
    CheckedStream(const fs::path& path, std::uint64_t max_file_bytes, std::optional<model::Error>& trouble)
        : file_(path), trouble_(trouble) {
        file_.check_size(max_file_bytes);
    }

    std::size_t Read(void* into, std::size_t size, std::size_t count) override {
        if (size == 0) return 0;
        try {
            const std::size_t got = file_.read({static_cast<std::byte*>(into), size * count});
            at_ += got;
            return got / size;
        } catch (const model::Error& error) {
            if (!trouble_) trouble_ = error;
            return 0;
        }
    }
    std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
    aiReturn Seek(std::size_t offset, aiOrigin origin) override {
        const std::uint64_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? at_ : file_.size();
        const std::uint64_t to = from + offset;  // backwards by a number that wraps around, as fseek() takes it
        if (to > file_.size() || !file_.seek(to)) return aiReturn_FAILURE;
        at_ = to;
        return aiReturn_SUCCESS;
    }
    [[nodiscard]] std::size_t Tell() const override { return at_; }
    [[nodiscard]] std::size_t FileSize() const override { return file_.size(); }
    void Flush() override {}

 private:
    RegularFile file_;
    std::optional<model::Error>& trouble_;
    std::uint64_t at_ = 0;
};

}  // namespace

bool GuardedIo::Exists(const char* file) const {
    try {
        return may_open(file) && DefaultIOSystem::Exists(file);
    } catch (const model::Error& error) {
        if (!files_.trouble) files_.trouble = error;
        return false;
    }
}

Assimp::IOStream* GuardedIo::Open(const char* file, const char* mode) {
    const bool reads = mode != nullptr && mode[0] == 'r' && std::string_view(mode).find('+') == std::string_view::npos;
    if (!reads) return nullptr;
    try {
        if (!may_open(file)) {
            files_.refused.emplace_back(file);
            return nullptr;
        }
        auto stream = std::make_unique<CheckedStream>(file, max_file_bytes_, files_.trouble);
        files_.opened.emplace_back(file);
        return stream.release();
    } catch (const model::Error& error) {
        if (!files_.trouble && error.code().number != model::codes::kFileMissing.number) files_.trouble = error;
        return nullptr;
    }
}

void GuardedIo::Close(Assimp::IOStream* stream) {
    delete stream;
}

bool GuardedIo::may_open(const fs::path& file) const {
    if (file == mesh_file_) return true;
    const fs::file_status status = look_at(file);
    if (fs::exists(status)) return fs::is_regular_file(status) && folders_.hold(file);
    return folders_.hold(file.has_parent_path() ? file.parent_path() : fs::path("."));
}

}  // namespace dgm::formats
