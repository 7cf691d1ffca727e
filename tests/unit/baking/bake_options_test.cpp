// SPDX-License-Identifier: GPL-3.0-or-later
#include "baking/bake_options.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "model/error.h"

namespace dgm::bake {
namespace {

TEST(CanonicalSettings, NamesEveryFieldThatChangesTheLayers) {
    EXPECT_EQ(canonical_settings({}),
              "size=257x257;method=auto;domain=auto;fit=l2;precision=f32;layers=all;texture=none;texture_size=grid");
    BakeOptions options;
    options.size = {33, 65};
    options.method = Method::kLscm;
    options.domain = DomainChoice::kFree;
    options.fit = Fit::kL2;
    options.precision = Precision::kU16;
    options.layers = {"normal", "geometry", "normal"};
    options.texture_size = GridSize{512, 256};
    EXPECT_EQ(canonical_settings(options),
              "size=33x65;method=lscm;domain=free;fit=l2;precision=u16;layers=geometry,normal;texture=none;"
              "texture_size=512x256");
    options.bump_size = GridSize{17, 9};
    options.ablate = {"newton", "cut-search", "newton"};  // in one order, once each
    EXPECT_EQ(canonical_settings(options),
              "size=33x65;method=lscm;domain=free;fit=l2;precision=u16;layers=geometry,normal;texture=none;"
              "texture_size=512x256;bump_size=17x9;without=cut-search;without=newton");
}

TEST(CanonicalSettings, NamesWhatWasAsked) {
    BakeOptions options;
    options.any_aspect = true;  // 257x257 that was named gives other layers of a ring
    EXPECT_EQ(canonical_settings(options).substr(0, 23), "size=257x257;shape=any;");
    options.any_aspect = false;
    options.auto_samples = 66049;
    options.max_error = ErrorGoal{0.05, true, ErrorKind::kHausdorff};
    options.budget_bytes = 262144;
    EXPECT_EQ(canonical_settings(options).substr(0, 83),
              "size=auto:66049;max_error=0.05%;max_error_kind=hausdorff;budget=262144;method=auto;");
    options.max_error->percent = false;
    EXPECT_NE(canonical_settings(options).find(";max_error=0.05;"), std::string::npos);
}

TEST(CanonicalSettings, LeavesOutWhichFilesAreWritten) {
    BakeOptions options;
    options.write_dgm = false;
    options.write_exr = true;
    options.exr_layout = ExrLayout::kMultipart;
    EXPECT_EQ(canonical_settings(options), canonical_settings({}));
}

TEST(CanonicalSettings, TextureCountsByContentNotByName) {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "dgm-settings-test";
    std::filesystem::create_directories(folder);
    const auto with = [&](const char* name, const char* content) {
        std::ofstream(folder / name, std::ios::binary) << content;
        BakeOptions options;
        options.texture = folder / name;
        return canonical_settings(options);
    };
    const std::string denim = with("denim.png", "blue");
    EXPECT_EQ(denim, with("copy.png", "blue"));
    EXPECT_NE(denim, with("denim.png", "red"));
    std::filesystem::remove_all(folder);
    BakeOptions missing;
    missing.texture = folder / "denim.png";
    EXPECT_THROW((void)canonical_settings(missing), model::Error);
}

}  // namespace
}  // namespace dgm::bake
