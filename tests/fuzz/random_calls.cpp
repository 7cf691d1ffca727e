// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/random_calls.cpp
// random_calls FIRST COUNT [SECONDS]: programs of fuzz_calls by number, without libFuzzer. Before each the number is
// put where a crash finds it: the last one printed is the one that broke; run it alone by `random_calls NUMBER 1`.
// Writes nothing but that. The bytes of program n are n in eight bytes, lowest first: what a file of corpus/calls
// holds.
#include <unistd.h>

#include <chrono>
#include <cinttypes>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "target.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define DGM_SANITIZED 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__)
#define DGM_SANITIZED 1
#endif

namespace {
#ifdef DGM_SANITIZED
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif
constexpr unsigned kMostSeconds = 20;
volatile std::uint64_t g_running = 0;

extern "C" void say_which(int) {
    std::fprintf(stderr, "random_calls: program %" PRIu64 "\n", std::uint64_t{g_running});
    std::_Exit(7);
}
}  // namespace

int main(int argc, char** argv) {
    if (argc != 3 && argc != 4) return 1;
    const std::uint64_t first = std::strtoull(argv[1], nullptr, 10), count = std::strtoull(argv[2], nullptr, 10);
    const double limit = argc == 4 ? std::strtod(argv[3], nullptr) : 1e18;
    // Faults too, unless a sanitizer reports them first (ASAN_OPTIONS=abort_on_error=1 ends with an abort).
    if (!kSanitized)
        for (const int signal : {SIGSEGV, SIGFPE, SIGBUS}) std::signal(signal, say_which);
    std::signal(SIGABRT, say_which);
    std::signal(SIGALRM, say_which);  // a program takes milliseconds: one that runs for seconds never ends
    const auto start = std::chrono::steady_clock::now();
    std::uint64_t done = 0;
    for (; done < count; ++done) {
        if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > limit) break;
        g_running = first + done;
        alarm(kMostSeconds);
        std::uint8_t bytes[8];
        for (int k = 0; k < 8; ++k) bytes[k] = static_cast<std::uint8_t>((first + done) >> 8 * k);
        LLVMFuzzerTestOneInput(bytes, sizeof bytes);
    }
    std::printf("random_calls: %" PRIu64 " programs from %" PRIu64 ": nothing found\n", done, first);
    return 0;
}
