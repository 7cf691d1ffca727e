// SPDX-License-Identifier: MIT
// libdgm/src/file/mapped_file_none.cpp
// Targets without mapped files: WebAssembly, and builds that define DGM_NO_FILES (see mapped_file.h).
#include "file/mapped_file.h"

#if defined(DGM_NO_FILES) || defined(__wasm__)

namespace dgm::detail {

Result<MappedFile> MappedFile::open(const char*, std::uint64_t) noexcept {
    return Error{ErrorCode::Unsupported, kNoOffset,
                 "this platform maps no files; read the file yourself and use open_memory"};
}

MappedFile::~MappedFile() = default;

}  // namespace dgm::detail

#endif
