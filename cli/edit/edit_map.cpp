// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/edit_map.cpp
#include "edit/edit_map.h"

#include <system_error>

#include "dgm/dgm_reader.h"
#include "edit/edit_record.h"
#include "edit/edit_sources.h"
#include "edit/painted_map.h"
#include "files/atomic_file.h"
#include "files/output_file.h"
#include "files/staging_folder.h"
#include "mesh/mesh_formats.h"
#include "model/codes.h"
#include "model/file_errors.h"
#include "worker/output_files.h"

namespace dgm::edit {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

/// What the painter has done to the map: all numbers compared, nothing written.
struct Painted {
    model::MapSet before;
    PartChoice choice;
    PaintedMap map{before, choice};
    bool is_damaged = false;  ///< the map's own hashes do not fit

    Painted(model::MapSet maps, const EditOptions& options) : before(std::move(maps)), choice(before, options.layers) {}
    Painted(const Painted&) = delete;
    Painted& operator=(const Painted&) = delete;
};

void trust_layers(Painted& painted, const formats::ChangedDgm& changed, const fs::path& map) {
    painted.is_damaged = !changed.rest_fits;
    for (std::size_t c = 0; c < changed.fits.size(); ++c)
        for (std::size_t l = 0; l < changed.fits[c].size(); ++l) {
            if (changed.fits[c][l]) continue;
            painted.is_damaged = true;
            painted.map.trust(c, l, map);
        }
}

void write_map(const Painted& painted, const EditOptions& options, const fs::path& output, bool is_changed) {
    formats::make_folder_of(output);
    const fs::path target = formats::destination_of(output).path;
    const formats::StagingFolder staging(target);
    const fs::path temporary = staging.where(target.filename());
    if (is_changed) {
        bake::write_verified(temporary, painted.map.maps(), bake::OutputFormat::kDgm, bake::ExrLayout::kAuto);
    } else {  // its own bytes, whichever library wrote them
        std::error_code error;
        fs::copy_file(options.map, temporary, fs::copy_options::overwrite_existing, error);
        if (error) throw bake::explained(model::unwritable_file(output, error.message()), temporary);
    }
    formats::publish_file(temporary, target);
}

}  // namespace

EditOutcome edit_map(const EditOptions& options) {
    formats::check_map_name(options.map);
    formats::ChangedDgm changed;
    if (options.repair)
        changed = formats::read_changed_dgm(options.map);
    else
        changed.maps = formats::read_dgm(options.map);
    Painted painted(std::move(changed.maps), options);
    if (options.repair) trust_layers(painted, changed, options.map);
    if (!options.source.empty()) offer_edit(painted.map, options.source);
    painted.map.finish();
    EditOutcome out;
    out.is_changed = painted.is_damaged || !painted.map.is_unchanged();
    out.lines = edit_lines(painted.map);
    if (out.is_changed) {
        check_result(painted.map);
        record_edits(painted.map);
    }
    const fs::path output = options.output.empty() ? options.map : options.output;
    std::error_code error;
    const bool in_place = options.output.empty() || fs::equivalent(output, options.map, error);
    if (options.dry_run || (in_place && !out.is_changed)) return out;
    write_map(painted, options, output, out.is_changed);
    out.is_written = true;
    return out;
}

}  // namespace dgm::edit
