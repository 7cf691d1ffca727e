// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/exr_apart.h
// EXR files are read in disposable processes: OpenEXR and its codecs unpack what strangers have packed.
#pragma once
#include "exr/exr_reader.h"
#include "model/error.h"
#include "process/fork_server.h"

namespace dgm::bake {

/// While it lives, formats::read_exr() and read_exr_head() read every file in a process of its own, which can read the
/// file's folder (layers of other sizes are files beside it) and do nothing else (sandbox.h). If it dies, the file is
/// unreadable (kExrUnreadable) and the program goes on. Create it as a ForkServer.
class ExrApart {
 public:
    /// @throws model::Error kSystemBusy
    ExrApart();
    ExrApart(const ExrApart&) = delete;
    ExrApart& operator=(const ExrApart&) = delete;
    ~ExrApart();

 private:
    [[nodiscard]] formats::ExrHead read(const std::filesystem::path& path, const formats::ExrReadLimits& limits,
                                        formats::ExrPixels pixels);
    ForkServer server_;
};

/// The message of the disposable process but for the layers' bytes, which follow it in their order.
[[nodiscard]] std::string encode_exr(const formats::ExrHead& exr);
/// Layers have no bytes yet; `sizes` gets how many each has.
/// nullopt for bytes that are none, or for layers whose sizes do not follow from their shapes or are beyond `limits`.
/// @throws model::Error the one that was sent
[[nodiscard]] std::optional<formats::ExrHead> decode_exr(std::string_view bytes, const formats::ExrReadLimits& limits,
                                                         std::vector<std::uint64_t>& sizes);
[[nodiscard]] std::string encode_exr(const model::Error& error);

}  // namespace dgm::bake
