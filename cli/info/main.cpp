// SPDX-License-Identifier: GPL-3.0-or-later
// cli/info/main.cpp
// dgm-info: what is in a .dgm.
#include <cstdio>
#include <string>
#include <vector>

#include "info/file_info.h"
#include "tool/tool.h"

int main(int argc, char** argv) {
    CLI::App app("Prints what a .dgm holds: charts, layers, measured errors.");
    std::vector<std::string> files;
    bool json = false;
    app.add_option("FILE", files, "The .dgm files to read")->required();
    app.add_flag("--json", json, "Print JSON");

    return dgm::tool::run_tool("dgm-info", argc, argv, app, [&](std::string& subject) {
        std::vector<dgm::info::FileInfo> infos;
        dgm::model::ExitCode worst = dgm::model::ExitCode::kOk;
        for (const std::string& file : files) {
            subject = file;
            try {
                infos.push_back(dgm::info::read_file_info(file));
                if (!json) std::fputs(dgm::info::to_text(infos.back()).c_str(), stdout);
            } catch (const dgm::model::Error& error) {  // the other files are still worth telling about
                dgm::tool::print_error("dgm-info", file, error);
                worst = dgm::model::worse(worst, error.code().exit);
            }
        }
        if (json) std::fputs(dgm::info::to_json(infos).c_str(), stdout);
        return static_cast<int>(worst);
    });
}
