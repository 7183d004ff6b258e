#include <gtest/gtest.h>

#include "formats/plain_image.h"
#include "pipeline/command/converter.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

using formats::Image;

/// A light source 10^18 times as bright as the rest: no 16-bit float holds both, and the report counts the lost texels of each level.
TEST(Cubemap, LightLostByTheDivisionIsCountedByLevel) {
    const formats::TemporaryFolder folder;
    for (const bool isDark : {false, true}) {
        Image<glm::vec4> sky(16, 8, glm::vec4(isDark ? 1e-12f : 0.5f));
        if (isDark) sky.at(3, 2) = glm::vec4(1e6f);
        ASSERT_TRUE(formats::writeExr(folder / "sky.exr", sky.view(), 3));
        Conversion options{"cubemap", folder / "sky.exr", folder / (isDark ? "dark" : "calm")};
        options.cook.cache = folder / "cache";
        options.cook.given.set("output.target", "float");
        const Outcome outcome = convert(options, RunState());
        ASSERT_TRUE(outcome.report.is_object());
        const Json& notes = outcome.report.at("assets").at(0).at("notes");
        EXPECT_TRUE(notes.at("division_clamped").empty());
        EXPECT_EQ(notes.at("division_lost").empty(), !isDark);
        if (isDark) {
            EXPECT_GT(notes.at("division_lost").at("level 0").get<int>(), 6 * 128 * 128);
        }
    }
}

}  // namespace
}  // namespace lightcook::pipeline
