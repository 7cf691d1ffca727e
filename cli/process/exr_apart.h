// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/exr_apart.h
// EXR files are read in disposable processes: OpenEXR and its codecs unpack what strangers have packed.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "exr/exr_planes.h"
#include "exr/exr_reader.h"
#include "process/fork_server.h"

namespace dgm::bake {

/// While it lives, the functions of exr_reader.h and exr_planes.h read every file in a process of its own, which can
/// read the file's folder (layers of other sizes are files beside it) and do nothing else (sandbox.h). If it dies, the
/// file is unreadable (kExrUnreadable) and the program goes on. Create it as a ForkServer.
class ExrApart {
 public:
    /// @param planes  works in those processes for what exr_planes.h reads; another one is for tests
    /// @throws model::Error kSystemBusy
    explicit ExrApart(const formats::ExrPlaneReader& planes = formats::exr_plane_reader_here());
    ExrApart(const ExrApart&) = delete;
    ExrApart& operator=(const ExrApart&) = delete;
    ~ExrApart();

 private:
    ForkServer server_;
};

/// The message of the disposable process but for the layers' bytes, which follow it in their order.
[[nodiscard]] std::string encode_exr(const formats::ExrHead& exr);
/// Layers have no bytes yet; `sizes` gets how many each has.
/// nullopt for bytes that are none, or for layers whose sizes do not follow from their shapes or are beyond `limits`.
[[nodiscard]] std::optional<formats::ExrHead> decode_exr(std::string_view bytes, const formats::ExrReadLimits& limits,
                                                         std::vector<std::uint64_t>& sizes);

/// The same of planes; their values follow it.
[[nodiscard]] std::string encode_planes(const std::vector<formats::ExrPlane>& planes);
/// nullopt for bytes that are none, and for planes that none of the map's layers has or that are beyond `limits`.
/// @param counts  gets how many values each has
[[nodiscard]] std::optional<std::vector<formats::ExrPlane>> decode_planes(std::string_view bytes,
                                                                          const std::vector<model::Chart>& charts,
                                                                          const formats::ExrReadLimits& limits,
                                                                          std::vector<std::uint64_t>& counts);

}  // namespace dgm::bake
