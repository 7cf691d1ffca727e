// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_run.cpp
// fuzz_open with every call on states: deform, track, tick, contact, snapshots, levels of detail.
#define DGM_FUZZ_CALL_STATES 1
#include "fuzz_open.cpp"
