// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/error_stream.h
// Errors between a disposable process and its program: the message that any reader may answer with.
#pragma once
#include <string>
#include <string_view>

#include "model/error.h"

namespace dgm::bake {

/// A message of its own: its first byte is the kind of no other message.
[[nodiscard]] std::string encode_error(const model::Error& error);

/// Nothing for other messages. @throws model::Error the one that `message` holds; kInternal for an unknown code
void throw_sent_error(std::string_view message);

}  // namespace dgm::bake
