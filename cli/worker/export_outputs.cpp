// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/export_outputs.cpp
#include "worker/export_outputs.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "export/export_files.h"
#include "files/staging_folder.h"
#include "model/codes.h"
#include "worker/output_files.h"

namespace dgm::bake {
namespace {
namespace fs = std::filesystem;
namespace codes = model::codes;
}  // namespace

void write_exports(const model::MapSet& maps, const std::vector<fs::path>& exports) {
    for (const fs::path& output : exports) {
        try {
            exporter::export_maps(maps, output, {}, {});
        } catch (const model::Error& error) {
            const fs::path probe = output.parent_path() / ".probe";  // goes away with the folder
            throw explained(error, probe);
        }
    }
}

std::vector<ExportedFile> exported_files(const fs::path& folder, const fs::path& final_path,
                                         const std::vector<fs::path>& inputs) {
    std::vector<fs::path> names;
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
        if (std::error_code ignored; it->is_regular_file(ignored) && !formats::is_staging_lock(it->path()))
            names.push_back(it->path().filename());
    const auto main = std::find(names.begin(), names.end(), final_path.filename());
    if (error || main == names.end())
        throw model::Error(codes::kWriteFailed, "the written file is gone", final_path.string());
    std::iter_swap(main, names.end() - 1);
    std::sort(names.begin(), names.end() - 1);

    std::vector<ExportedFile> out;
    for (const fs::path& name : names) {
        ExportedFile& file = out.emplace_back(ExportedFile{folder / name, final_path.parent_path() / name, 0});
        file.bytes = fs::file_size(file.temporary, error);
        if (error) throw model::Error(codes::kWriteFailed, "the written file is gone", file.final_path.string());
        for (const fs::path& input : inputs)
            if (std::error_code ignored; fs::equivalent(input, file.final_path, ignored))
                throw model::Error(codes::kUsage, "the output would overwrite a file that the mesh was read from",
                                   file.final_path.string());
    }
    return out;
}

}  // namespace dgm::bake
