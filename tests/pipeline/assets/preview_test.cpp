#include "pipeline/assets/preview.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <array>

#include "formats/plain_image.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

formats::Image<glm::vec4> differenceOf(const Preview& preview) {
    const formats::TemporaryFolder folder;
    const auto files = preview.write(folder / "", "map");
    EXPECT_TRUE(files.has_value());
    EXPECT_EQ(files->difference, "preview/map_difference.png");
    auto picture = formats::readImage(folder / files->difference);
    return std::move(picture->texels);
}

/// 800 texels are 267 pixels of three: an error at a texel that no pixel stands for is seen all the same, and only there.
TEST(Preview, NoErrorHidesBetweenPixels) {
    Preview preview(800, 6, 1);
    ASSERT_EQ(preview.stride(), 3);
    ASSERT_FALSE(preview.shows(301, 4));
    preview.set(301, 4, glm::vec3(1), glm::vec3(2));
    preview.set(300, 3, glm::vec3(1), glm::vec3(1));
    preview.set(302, 5, glm::vec3(1), glm::vec3(1));
    const auto picture = differenceOf(preview);
    for (int y = 0; y < picture.height(); ++y)
        for (int x = 0; x < picture.width(); ++x) {
            const bool isWorst = x == 100 && y == 1;
            EXPECT_EQ(picture.at(x, y).x > 0.9f, isWorst) << x << ", " << y;
        }
}

/// The scale of visible errors ends at 10, and does not look at the light.
TEST(Preview, ShowsVisibleErrorsOnTheirOwnScale) {
    Preview preview(4, 1, 1);
    for (int x = 0; x < 4; ++x)
        preview.set(x, 0, glm::vec3(1), glm::vec3(2), static_cast<float>(std::array{0, 5, 10, 500}[static_cast<std::size_t>(x)]));
    const auto picture = differenceOf(preview);
    EXPECT_EQ(picture.at(0, 0), glm::vec4(0, 0, 0, 1));
    EXPECT_GT(picture.at(1, 0).x, picture.at(1, 0).z) << "orange";
    EXPECT_LT(picture.at(1, 0).y, 0.9f);
    EXPECT_EQ(picture.at(2, 0), glm::vec4(1));
    EXPECT_EQ(picture.at(3, 0), glm::vec4(1));
}

/// Whoever comes last, the worst stays: pixels are the same however threads meet.
TEST(Preview, ThreadsMayShareAPixel) {
    Preview preview(3840, 3840, 0);
    ASSERT_EQ(preview.stride(), 10);
    tbb::parallel_for(0, 3840, [&](int y) {
        for (int x = 0; x < 3840; ++x) preview.set(x, y, glm::vec3(1), glm::vec3(1 + 1e-3f * static_cast<float>((7 * x + 3 * y) % 97)));
    });
    const auto picture = differenceOf(preview);
    Preview again(3840, 3840, 0);
    for (int y = 3839; y >= 0; --y)
        for (int x = 0; x < 3840; ++x) again.set(x, y, glm::vec3(1), glm::vec3(1 + 1e-3f * static_cast<float>((7 * x + 3 * y) % 97)));
    const auto expected = differenceOf(again);
    EXPECT_TRUE(std::ranges::equal(picture.texels(), expected.texels()));
}

/// Only a preview that was told of them has a picture of the errors at any normal.
TEST(Preview, ShowsErrorsAtAnyNormalWhereTheyWereSet) {
    Preview preview(3, 1, 1);
    const formats::TemporaryFolder folder;
    EXPECT_FALSE(preview.write(folder / "", "map")->anyNormal.has_value());
    preview.setAtAnyNormal(1, 0, 10);
    const auto files = preview.write(folder / "", "map");
    ASSERT_TRUE(files && files->anyNormal);
    EXPECT_EQ(files->all().size(), 4u);
    const auto picture = formats::readImage(folder / *files->anyNormal);
    ASSERT_TRUE(picture.has_value());
    EXPECT_EQ(picture->texels.at(0, 0), glm::vec4(0, 0, 0, 1));
    EXPECT_EQ(picture->texels.at(1, 0), glm::vec4(1));
}

}  // namespace
}  // namespace lightcook::pipeline
