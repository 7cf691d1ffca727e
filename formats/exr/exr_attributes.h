// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_attributes.h
// Names of the header attributes (SPEC.md section 5). All are of the types int and string: other programs keep those
// when they save a file again.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace dgm::formats {

/// In the map's own file: the first part describes everything.
inline constexpr char kLayoutVersionAttribute[] = "dgmExrLayout", kLayoutNameAttribute[] = "dgmParts",
                      kFormatVersionAttribute[] = "dgmFormatVersion", kChartCountAttribute[] = "dgmChartCount",
                      kGeneratorAttribute[] = "dgmGenerator", kSourceNameAttribute[] = "dgmSourceName",
                      kSourceHashAttribute[] = "dgmSourceHash", kSettingsHashAttribute[] = "dgmSettingsHash",
                      kReportAttribute[] = "dgmReport", kHeaderHashAttribute[] = "dgmHeaderHash";
/// In a file of layers: the name that it has behind that of the map.
inline constexpr char kSideFileAttribute[] = "dgmSideFile";

/// `dgmChart0.rows`; also `.table.<layer>`, `.hash.<layer>` and `.attribute.<layer>/<name>`.
[[nodiscard]] inline std::string chart_attribute(std::size_t chart, std::string_view name) {
    return "dgmChart" + std::to_string(chart) + "." + std::string(name);
}

}  // namespace dgm::formats
