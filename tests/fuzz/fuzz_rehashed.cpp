// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/fuzz_rehashed.cpp
// A map whose hashes and HDF5 checksums fit, whatever it holds (rehashed_maps.h), through the validator, then through
// the runtime. The bytes are decisions (dice.h): no file is read.
//
// Promises: the validator ends with findings that have codes, whatever happens to the process that reads HDF5; what it
// accepts, the runtime opens and makes states of; any calls on what the runtime accepts keep fuzz_calls_program.cpp's.
#include <dgm/validate.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "call_checks.h"
#include "fuzz_calls.h"
#include "process/hdf5_apart.h"
#include "rehashed_maps.h"
#include "support/temp_folder.h"
#include "target.h"
#include "validate/validation.h"

namespace {
namespace fs = std::filesystem;
using namespace dgm;
using test::is_saying;

/// In memory where that can be.
fs::path folder_of_scratch() {
    return fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path();
}

bool is_accepted(const fs::path& path) {
    const validate::FileValidation result = validate::validate_file(path);
    bool good = true;
    for (const formats::Finding& finding : result.findings) {
        test::promise(finding.code != nullptr && !finding.message.empty(), "a finding says nothing");
        good = good && finding.severity != formats::Severity::kError;
    }
    test::promise(good == (result.exit_code() == model::ExitCode::kOk), "exit code and findings disagree");
    return good;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const bake::Hdf5Apart hdf5;  // before anything else: it copies this process
    static const test::TempFolder scratch(folder_of_scratch());
    test::Dice dice({data, size});
    const fs::path path = scratch / "map.dgm";
    const std::string file = test::rehashed_dgm(dice, path);
    std::ofstream(path, std::ios::binary).write(file.data(), static_cast<std::streamsize>(file.size()));
    const bool accepted = is_accepted(path);

    std::vector<std::byte> bytes(file.size());
    std::memcpy(bytes.data(), file.data(), file.size());
    OpenOptions options;
    options.max_samples = 1u << 20;
    options.verify_hashes = true;
    const auto asset = Asset::open_memory(bytes, options);
    if (!asset.ok() && accepted)
        DGM_SAY("error %d at %lld: %s\n", static_cast<int>(asset.error().code),
                static_cast<long long>(asset.error().byte_offset), asset.error().message);
    test::promise(asset.ok() || !accepted, "the runtime does not open what the validator accepts");
    DGM_SAY("%s\n", accepted ? "accepted" : asset.ok() ? "opened" : "refused");
    if (!asset) return 0;
    for (std::uint32_t c = 0; c < asset.value().chart_count(); ++c)
        test::promise(validate_chart(asset.value().chart(c).value()).ok() || !accepted,
                      "the runtime refuses a chart that the validator accepts");
    if (dice.one_in(4))
        test::call_c(dice, bytes);
    else
        test::call_all(dice, asset.value());
    return 0;
}
