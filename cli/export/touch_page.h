// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/touch_page.h
// Maps as a page to touch.
#pragma once
#include <filesystem>
#include <vector>

#include "export/export_files.h"
#include "export/staging_folder.h"
#include "page/page_file.h"

namespace dgm::exporter {

/// Adds the page of `maps` to `staging`, with a picture of the first map for browsers that cannot draw.
/// @throws model::Error as page::page_file() and render::surface_picture()
void write_touch_page(const std::vector<page::PagedMap>& maps, const std::filesystem::path& output,
                      const ExportOptions& options, StagingFolder& staging);

}  // namespace dgm::exporter
