// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/error_stream.cpp
#include "process/error_stream.h"

#include <cstdint>

#include "model/codes.h"
#include "process/byte_stream.h"
#include "process/worker_io.h"

namespace dgm::bake {
namespace {

constexpr char kError = 'E';

}  // namespace

std::string encode_error(const model::Error& error) {
    ByteWriter out;
    out.put(kError);
    out.put(std::int32_t{error.code().number});
    out.put(std::string(error.what()));
    out.put(error.place());
    out.put(std::string(error.hint()));
    return out.take();
}

void throw_sent_error(std::string_view message) {
    ByteReader in(message);
    if (in.get<char>() != kError) return;
    const model::Code* code = code_of(in.get<std::int32_t>());
    const std::string text = in.text(), place = in.text(), hint = in.text();
    throw model::Error(code != nullptr ? *code : model::codes::kInternal, text, place).with_hint(hint);
}

}  // namespace dgm::bake
