// SPDX-License-Identifier: MIT
// libdgm/src/file/mapped_file_win32.cpp
// Windows: paths are UTF-8, as everywhere else, whatever the process's code page is.
#include "file/mapped_file.h"

#if defined(_WIN32) && !defined(DGM_NO_FILES)

#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>

#include <limits>

namespace dgm::detail {
namespace {
/// UTF-16 units of a path, the end included: as many as Linux takes bytes.
constexpr int kMaxPath = 4096;

struct Handle {
    HANDLE value;
    explicit Handle(HANDLE h) noexcept : value(h) {}
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle() {
        if (is_open()) ::CloseHandle(value);
    }
    [[nodiscard]] bool is_open() const noexcept { return value != nullptr && value != INVALID_HANDLE_VALUE; }
};

bool means_missing(DWORD error) noexcept {
    switch (error) {
        case ERROR_FILE_NOT_FOUND:
        case ERROR_PATH_NOT_FOUND:
        case ERROR_INVALID_NAME:  // no file can have such a name
        case ERROR_BAD_PATHNAME:
        case ERROR_INVALID_DRIVE:
        case ERROR_BAD_NETPATH:
        case ERROR_BAD_NET_NAME:
            return true;
        default:
            return false;
    }
}

HANDLE open_handle(const wchar_t* path) noexcept {
    // Others may go on using the file, as on POSIX. A pipe's server must not act in our name: SECURITY_ANONYMOUS.
    constexpr DWORD kShare = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
    constexpr DWORD kFlags = FILE_ATTRIBUTE_NORMAL | SECURITY_SQOS_PRESENT | SECURITY_ANONYMOUS;
    return ::CreateFileW(path, GENERIC_READ, kShare, nullptr, OPEN_EXISTING, kFlags, nullptr);
}
}  // namespace

Result<MappedFile> MappedFile::open(const char* path, std::uint64_t max_bytes) noexcept {
    wchar_t wide[kMaxPath];
    if (::MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, wide, kMaxPath) == 0)
        return Error{ErrorCode::ReadFailed, kNoOffset, "the path is not UTF-8, or too long"};
    const Handle file(open_handle(wide));
    if (!file.is_open()) {
        if (means_missing(::GetLastError())) return Error{ErrorCode::FileMissing, kNoOffset, "the file does not exist"};
        return Error{ErrorCode::ReadFailed, kNoOffset, "the file cannot be opened for reading"};
    }
    // Consoles, ports and pipes are no disk files; a raw disk is one without information.
    BY_HANDLE_FILE_INFORMATION info = {};
    if (::GetFileType(file.value) != FILE_TYPE_DISK || !::GetFileInformationByHandle(file.value, &info) ||
        (info.dwFileAttributes & (FILE_ATTRIBUTE_DIRECTORY | FILE_ATTRIBUTE_DEVICE)) != 0)
        return Error{ErrorCode::ReadFailed, kNoOffset, "the path is not a regular file"};
    const std::uint64_t size = std::uint64_t{info.nFileSizeHigh} << 32 | info.nFileSizeLow;
    if (size > max_bytes || size > std::numeric_limits<std::size_t>::max() / 2)
        return Error{ErrorCode::LimitExceeded, kNoOffset, "the file is longer than the limit allows"};
    MappedFile mapped;
    if (size == 0) return mapped;
    // The size is given, so that a file cut short meanwhile is refused. The view keeps what it needs open.
    const Handle mapping(
        ::CreateFileMappingW(file.value, nullptr, PAGE_READONLY, info.nFileSizeHigh, info.nFileSizeLow, nullptr));
    const void* memory =
        !mapping.is_open() ? nullptr : ::MapViewOfFile(mapping.value, FILE_MAP_READ, 0, 0, static_cast<SIZE_T>(size));
    if (memory == nullptr) return Error{ErrorCode::ReadFailed, kNoOffset, "the file cannot be mapped"};
    mapped.bytes_ = {static_cast<const std::byte*>(memory), static_cast<std::size_t>(size)};
    return mapped;
}

MappedFile::~MappedFile() {
    if (bytes_.data() != nullptr) ::UnmapViewOfFile(bytes_.data());
}

}  // namespace dgm::detail

#endif
