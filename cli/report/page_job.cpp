// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/page_job.cpp
#include "report/page_job.h"

#include <nlohmann/json.hpp>

#include "files/whole_file.h"
#include "model/codes.h"
#include "process/sandbox.h"
#include "worker/worker_protocol.h"

namespace dgm::report {
using nlohmann::json;

std::string encode(const PageJob& job) {
    json roots = json::array();
    for (const std::filesystem::path& root : job.page.asset_roots) roots.push_back(bake::encode_path(root));
    const json page{{"asset", job.page.asset},
                    {"source", bake::encode_path(job.page.source)},
                    {"map", bake::encode_path(job.page.map)},
                    {"command", bake::encode_path(job.page.command)},
                    {"key", job.page.key},
                    {"index_link", job.page.index_link},
                    {"asset_roots", roots},
                    {"output", bake::encode_path(job.output)}};
    return json{{"page", page}, {"memory_bytes", job.memory_bytes}, {"threads", job.threads}}.dump(
        -1, ' ', false, json::error_handler_t::replace);
}

PageJob decode_page_job(std::string_view text) {
    const bake::JobLimits limits = bake::decode_limits(text);
    try {
        const json page = json::parse(text).at("page");
        const auto path_at = [&](const char* key) { return bake::decode_path(page.at(key).get<std::string>()); };
        PageJob job;
        job.page = {page.at("asset"), path_at("source"),    path_at("map"), path_at("command").string(),
                    page.at("key"),   page.at("index_link")};
        for (const json& root : page.at("asset_roots"))
            job.page.asset_roots.push_back(bake::decode_path(root.get<std::string>()));
        job.output = path_at("output");
        job.memory_bytes = limits.memory_bytes;
        job.threads = limits.threads;
        return job;
    } catch (const json::exception& error) {
        throw model::Error(model::codes::kInternal,
                           std::string("the worker was given a malformed page: ") + error.what());
    }
}

void make_page(std::string_view text) {
    const PageJob job = decode_page_job(text);
    std::vector<std::filesystem::path> readable = job.page.asset_roots;
    readable.push_back(job.page.map.has_parent_path() ? job.page.map.parent_path() : ".");  // an EXR's layers, too
    static_cast<void>(bake::enter_sandbox(bake::worker_sandbox(job.page.source, std::move(readable), {job.output})));
    // The page takes the place of what was written there meanwhile.
    const std::string page = asset_page(job.page, job.output);
    formats::write_whole_file(job.output, page);
}

}  // namespace dgm::report
