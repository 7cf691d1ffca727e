// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_reading.h
// Makes one kind of error of whatever OpenEXR throws.
#pragma once
#include <exception>
#include <filesystem>
#include <new>
#include <string>

#include "model/codes.h"

namespace dgm::formats {

/// Runs `read`. @throws model::Error what it throws itself; kExrUnreadable for all else
template <class Read>
auto reading(const std::filesystem::path& path, const Read& read) {
    try {
        return read();
    } catch (const model::Error&) { throw; } catch (const std::bad_alloc&) {
        throw model::Error(model::codes::kExrUnreadable, "the file needs more memory than there is", path.string());
    } catch (const std::exception& e) {
        throw model::Error(model::codes::kExrUnreadable, std::string("OpenEXR: ") + e.what(), path.string());
    }
}

}  // namespace dgm::formats
