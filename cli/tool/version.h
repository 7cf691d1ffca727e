// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/version.h
// Names the version of the programs, from CMakeLists.txt, and the commit they were built from.
#pragma once
#include <string>
#include <string_view>

namespace dgm::tool {

/// "0.1.0": the version of the project. Man pages and files name this one, so that they do not change with each commit.
inline constexpr std::string_view kVersion = DGM_VERSION;
inline constexpr std::string_view kHomepage = DGM_HOMEPAGE;  ///< empty if the build was given none

/// "917011a", "917011a, modified" if a source that the programs are made of was changed since, or nothing if the
/// sources were no git checkout. The build writes it anew before it links; nothing else is compiled again.
[[nodiscard]] std::string_view commit();

/// "0.1.0 (917011a)", or "0.1.0" if the commit is unknown.
[[nodiscard]] inline std::string build_version() {
    std::string out(kVersion);
    if (!commit().empty()) out += " (" + std::string(commit()) + ")";
    return out;
}

/// "dgm-export 0.1.0 (917011a)"
[[nodiscard]] inline std::string version_line(const std::string& program) {
    return program + " " + build_version();
}

}  // namespace dgm::tool
