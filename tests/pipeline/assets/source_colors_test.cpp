#include "pipeline/assets/source_colors.h"

#include <gtest/gtest.h>

#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

TEST(IsColorConfigRole, IsTrueForTheConfigurationAndItsFilesAlone) {
    for (const char* role : {"color_config", "color_config-1", "color_config-12"}) EXPECT_TRUE(isColorConfigRole(role)) << role;
    for (const char* role : {"", "source", "source-px", "color", "color_configs"}) EXPECT_FALSE(isColorConfigRole(role)) << role;
    const formats::TemporaryFolder folder;
    formats::writeContent(folder / "config.ocio", "");
    formats::ColorSpaces colors;
    colors.config = folder / "config.ocio";
    for (const auto& [role, file] : sourceInputs("a.exr", colors)) EXPECT_EQ(isColorConfigRole(role), role != "source") << role;
}

}  // namespace
}  // namespace lightcook::pipeline
