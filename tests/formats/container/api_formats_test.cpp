#include "formats/api_formats.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace lightcook::formats {
namespace {

bool isAstc(const PixelFormatInfo& format) {
    return format.name.starts_with("astc");
}

TEST(ApiFormats, AreThoseOfTheTablesAndDifferFromFormatToFormat) {
    std::set<std::uint32_t> vulkan, gl, metal;
    for (const PixelFormatInfo& format : allPixelFormats()) {
        SCOPED_TRACE(std::string(format.name));
        const ApiFormats numbers = apiFormats(format.format);
        EXPECT_EQ(numbers.vulkan, format.vkFormat);
        EXPECT_EQ(numbers.dxgi.value_or(0), format.dxgiFormat);
        EXPECT_TRUE(vulkan.insert(numbers.vulkan).second);
        // OpenGL has one number for ASTC of either range.
        EXPECT_TRUE(gl.insert(numbers.gl).second || format.name == "astc-4x4-ldr");
        if (numbers.metal) {
            EXPECT_TRUE(metal.insert(*numbers.metal).second);
        }
        EXPECT_EQ(numbers.dxgi.has_value(), !isAstc(format) && format.name != "rgb16f");
        EXPECT_EQ(numbers.metal.has_value(), format.name != "rgb16f");
    }
}

/// From the specifications of the extensions and Metal's header: a block format of each kind, and one without blocks.
TEST(ApiFormats, AreThoseOfTheSpecifications) {
    EXPECT_EQ(apiFormats(PixelFormat::Bc7), (ApiFormats{145, 98, 0x8E8C, 152}));
    EXPECT_EQ(apiFormats(PixelFormat::Bc6hUf16), (ApiFormats{143, 95, 0x8E8F, 151}));
    EXPECT_EQ(apiFormats(PixelFormat::Bc6hSf16), (ApiFormats{144, 96, 0x8E8E, 150}));
    EXPECT_EQ(apiFormats(PixelFormat::Astc8x8Hdr), (ApiFormats{1000066007, {}, 0x93B7, 230}));
    EXPECT_EQ(apiFormats(PixelFormat::Rgb9e5), (ApiFormats{123, 67, 0x8C3D, 93}));
    EXPECT_EQ(apiFormats(PixelFormat::Rgba16f), (ApiFormats{97, 10, 0x881A, 115}));
}

}  // namespace
}  // namespace lightcook::formats
