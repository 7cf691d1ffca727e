// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/recorded_touch.h
#pragma once

namespace dgm::bench {

/// The text of samples/paths/recorded_touch.csv.
extern const char* const kRecordedTouch;

}  // namespace dgm::bench
