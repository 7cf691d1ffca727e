// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_threads.h
#pragma once
#include <IlmThreadPool.h>

namespace dgm::formats {

/// OpenEXR makes its pool of threads (which has none here) in the midst of reading and writing pixels, and waits for
/// ever if there is no memory for it. Call it before. @throws std::bad_alloc
inline void make_exr_threads() {
    static_cast<void>(IlmThread::ThreadPool::globalThreadPool());
}

}  // namespace dgm::formats
