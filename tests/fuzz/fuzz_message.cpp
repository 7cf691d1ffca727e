// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_message.cpp
// Messages that a worker may send to its parent after an untrusted mesh took it over. Promises: nonsense is nullopt;
// an understood message can be written again and is understood alike; paths that make no sense throw model::Error,
// nothing else does.
#include <string_view>

#include "target.h"
#include "worker/worker_protocol.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace dgm;
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    if (const auto message = bake::decode_message(text)) {
        const std::string line = bake::encode(*message);
        test::require(!line.empty() && line.back() == '\n' && line.find('\n') == line.size() - 1);
        const auto again = bake::decode_message(std::string_view(line).substr(0, line.size() - 1));
        test::require(again && again->index() == message->index() && bake::encode(*again) == line);
    }
    try {
        const std::filesystem::path path = bake::decode_path(text);
        test::require(bake::decode_path(bake::encode_path(path)) == path);
    } catch (const model::Error&) {
        // A per cent sign without two digits.
    }
    return 0;
}
