// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/worker_io.cpp
#include "process/worker_io.h"

#include <fcntl.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <limits>
#include <new>

namespace dgm::bake {
namespace {

/// Notifies the parent before anything else happens: the calling library may abort, or swallow the exception.
void on_allocation_failure() {
    static_cast<void>(send_message(kOutOfMemoryLine));
    std::set_new_handler(nullptr);
    throw std::bad_alloc();
}

}  // namespace

const model::Code* code_of(std::uint64_t number) {
    for (const model::Code* code : model::codes::kAll)
        if (static_cast<std::uint64_t>(code->number) == number) return code;
    return nullptr;
}

bool is_worker(int argc, const char* const* argv) {
    return argc == 2 && std::string_view(argv[1]) == "--worker";
}

bool has_message_descriptor() {
    if (fcntl(kMessageDescriptor, F_GETFD) >= 0) return true;
    std::fputs("--worker is how these programs start their own workers, not for use by hand\n", stderr);
    return false;
}

std::string read_job_text() {
    std::string text;
    std::array<char, 65536> buffer;
    for (;;) {
        const ssize_t n = read(kJobDescriptor, buffer.data(), buffer.size());
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return text;
        text.append(buffer.data(), static_cast<std::size_t>(n));
    }
}

void limit_worker_memory(std::uint64_t allowed, std::uint32_t threads) {
    // Each arena of glibc reserves 64 MiB of address space, by default eight a core: they would use the limit up.
    mallopt(M_ARENA_MAX, static_cast<int>(std::clamp(threads, 1U, 8U)));
    // A bake takes and gives back blocks of some MiB all the time: each would be mapped, filled with zeros and
    // unmapped.
    mallopt(M_MMAP_THRESHOLD, 32 << 20);
    mallopt(M_TRIM_THRESHOLD, 256 << 20);
    std::set_new_handler(on_allocation_failure);
#if defined(__SANITIZE_ADDRESS__)
    (void)allowed;  // the sanitizer's shadow memory alone is beyond any limit
#else
    if (allowed == 0) return;
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const std::uint64_t now = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    if (allowed > std::numeric_limits<std::uint64_t>::max() / 2 - now) return;
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0) return;
    limit.rlim_cur = std::min<rlim_t>(now + allowed, limit.rlim_max);
    limit.rlim_max = limit.rlim_cur;
    setrlimit(RLIMIT_AS, &limit);
#endif
}

bool send_message(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = write(kMessageDescriptor, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
}

}  // namespace dgm::bake
