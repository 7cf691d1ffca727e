// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "baking/stages.h"
#include "image/image.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;

/// Pictures cannot be read, for one reason.
class NoPictures {
 public:
    explicit NoPictures(const model::Code& why) {
        const auto fail = [&why](const model::PictureFile&) -> formats::Image { throw model::Error(why, "no"); };
        formats::ImageReader reader = formats::image_reader_here();
        reader.image = fail;
        formats::set_image_reader(reader);
    }
    ~NoPictures() { formats::set_image_reader({}); }
    NoPictures(const NoPictures&) = delete;
    NoPictures& operator=(const NoPictures&) = delete;
};

TEST(LoadImages, APictureIsLeftOutOnlyForGood) {
    std::vector<model::Material> materials(1);
    materials[0].diffuse_map.path = "skin.png";
    std::vector<std::string> warnings;
    {
        const NoPictures broken(codes::kImageUnreadable);
        EXPECT_FALSE(load_images(materials, {}, warnings).colour[0]);
        EXPECT_EQ(warnings.size(), 1U);
    }
    for (const model::Code* code : {&codes::kIoTrouble, &codes::kSystemBusy, &codes::kWorkerKilled}) {
        const NoPictures for_now(*code);
        EXPECT_THROW((void)load_images(materials, {}, warnings), model::Error) << code->name;
    }
    EXPECT_EQ(warnings.size(), 1U);
}

}  // namespace
}  // namespace dgm::bake
