// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/no_descriptors.h
#pragma once
#include <sys/resource.h>

namespace dgm::test {

/// While it lives this process can open nothing (EMFILE), as one with all its descriptors taken.
class NoDescriptors {
 public:
    NoDescriptors() {
        ::getrlimit(RLIMIT_NOFILE, &before_);
        const rlimit none{0, before_.rlim_max};
        ::setrlimit(RLIMIT_NOFILE, &none);
    }
    ~NoDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }
    NoDescriptors(const NoDescriptors&) = delete;
    NoDescriptors& operator=(const NoDescriptors&) = delete;

 private:
    rlimit before_{};
};

}  // namespace dgm::test
