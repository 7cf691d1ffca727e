// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/faults.h
// What a parser may do once a file has taken it over, for processes whose program must not notice more than an error.
#pragma once
#include <fcntl.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "process/sandbox.h"
#include "process/worker_io.h"

namespace dgm::test {

/// Each ends the process, or throws; none comes back unless it got out, and then the process lives on. Ways out are
/// among them where the system has all of the sandbox.
inline std::vector<std::pair<std::string, std::function<void()>>> faults() {
    const auto end_unless = [](bool is_out) {
        if (!is_out) std::abort();
    };
    std::vector<std::pair<std::string, std::function<void()>>> out = {
        {"crash", [] { raise(SIGSEGV); }},
        {"abort", [] { std::abort(); }},
        {"quit", [] { _exit(0); }},
        {"nonsense",
         [] {
             static_cast<void>(bake::send_message(std::string(4096, '\xff')));
             _exit(0);
         }},
        {"a head too long", [] {
             static_cast<void>(bake::send_message(std::string("\xff\xff\xff\xff\0\0\0\0", 8)));
             _exit(0);
         }}};
    if (!bake::sandbox_lacks().empty()) return out;
    out.insert(out.end(), {{"another file", [=] { end_unless(open("/etc/passwd", O_RDONLY) >= 0); }},
                           {"a socket", [=] { end_unless(socket(AF_INET, SOCK_STREAM, 0) >= 0); }},
                           {"another process", [=] { end_unless(fork() >= 0); }}});
    return out;
}

}  // namespace dgm::test
