// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/temporary_folder.cpp
#include "bench/temporary_folder.h"

#include <stdlib.h>

#include <string>

#include "model/codes.h"

namespace dgm::bench {

TemporaryFolder::TemporaryFolder() {
    std::error_code error;
    std::string name = (std::filesystem::temp_directory_path(error) / "dgm-bench-XXXXXX").string();
    if (error || mkdtemp(name.data()) == nullptr)
        throw model::Error(model::codes::kWriteFailed, "no temporary folder can be made", name);
    path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

}  // namespace dgm::bench
