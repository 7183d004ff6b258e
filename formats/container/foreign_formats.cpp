#include "formats/container/foreign_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

namespace lightcook::formats {
namespace {

using Names = std::span<const std::string_view>;

constexpr std::array<std::string_view, 7> kKinds8 = {"UNORM", "SNORM", "USCALED", "SSCALED", "UINT", "SINT", "SRGB"};
constexpr std::array<std::string_view, 7> kKinds16 = {"UNORM", "SNORM", "USCALED", "SSCALED", "UINT", "SINT", "SFLOAT"};
constexpr std::array<std::string_view, 3> kKinds32 = {"UINT", "SINT", "SFLOAT"};
constexpr std::array<std::string_view, 2> kKindsOfBlocks = {"UNORM_BLOCK", "SRGB_BLOCK"};
constexpr std::array<std::string_view, 1> kHdrBlock = {"SFLOAT_BLOCK"};

/// Formats in a row: each of the channels in each of the kinds.
struct VkRun {
    std::uint32_t first;
    Names channels, kinds;
    std::string_view ending = "";
};

constexpr std::array<std::string_view, 6> kPacked16 = {"R4G4B4A4", "B4G4R4A4", "R5G6B5", "B5G6R5", "R5G5B5A1", "B5G5R5A1"};
constexpr std::array<std::string_view, 1> kUnormPack16 = {"UNORM_PACK16"};
constexpr std::array<std::string_view, 6> kOf8 = {"R8", "R8G8", "R8G8B8", "B8G8R8", "R8G8B8A8", "B8G8R8A8"};
constexpr std::array<std::string_view, 1> kPacked8 = {"A8B8G8R8"};
constexpr std::array<std::string_view, 2> kOf10 = {"A2R10G10B10", "A2B10G10R10"};
constexpr std::array<std::string_view, 4> kOf16 = {"R16", "R16G16", "R16G16B16", "R16G16B16A16"};
constexpr std::array<std::string_view, 4> kOf32 = {"R32", "R32G32", "R32G32B32", "R32G32B32A32"};
constexpr std::array<std::string_view, 4> kOf64 = {"R64", "R64G64", "R64G64B64", "R64G64B64A64"};
constexpr std::array<std::string_view, 4> kBc1To3 = {"BC1_RGB", "BC1_RGBA", "BC2", "BC3"};
constexpr std::array<std::string_view, 1> kBc7 = {"BC7"};
constexpr std::array<std::string_view, 3> kEtc2 = {"ETC2_R8G8B8", "ETC2_R8G8B8A1", "ETC2_R8G8B8A8"};
constexpr std::array<std::string_view, 2> kEac = {"EAC_R11", "EAC_R11G11"};
constexpr std::array<std::string_view, 2> kKindsOfEac = {"UNORM_BLOCK", "SNORM_BLOCK"};
constexpr std::array<std::string_view, 14> kAstc = {"ASTC_4x4",  "ASTC_5x4",   "ASTC_5x5",   "ASTC_6x5",  "ASTC_6x6",
                                                    "ASTC_8x5",  "ASTC_8x6",   "ASTC_8x8",   "ASTC_10x5", "ASTC_10x6",
                                                    "ASTC_10x8", "ASTC_10x10", "ASTC_12x10", "ASTC_12x12"};
constexpr std::array<std::string_view, 4> kPvrtc = {"PVRTC1_2BPP", "PVRTC1_4BPP", "PVRTC2_2BPP", "PVRTC2_4BPP"};
constexpr std::array<std::string_view, 1> kUnormBlock = {"UNORM_BLOCK_IMG"}, kSrgbBlock = {"SRGB_BLOCK_IMG"};

constexpr std::array kVkRuns = {
    VkRun{2, kPacked16, kUnormPack16},
    VkRun{9, kOf8, kKinds8},
    VkRun{51, kPacked8, kKinds8, "_PACK32"},
    VkRun{58, kOf10, Names(kKinds8).first(6), "_PACK32"},
    VkRun{70, kOf16, kKinds16},
    VkRun{98, kOf32, kKinds32},
    VkRun{110, kOf64, kKinds32},
    VkRun{131, kBc1To3, kKindsOfBlocks},
    VkRun{145, kBc7, kKindsOfBlocks},
    VkRun{147, kEtc2, kKindsOfBlocks},
    VkRun{153, kEac, kKindsOfEac},
    VkRun{157, kAstc, kKindsOfBlocks},
    VkRun{1000066000, kAstc, kHdrBlock},
    VkRun{1000054000, kPvrtc, kUnormBlock},
    VkRun{1000054004, kPvrtc, kSrgbBlock},
};

struct NumberedName {
    std::uint32_t number;
    std::string_view name;
};
/// Those of no run.
constexpr std::array kOtherVkFormats = {
    NumberedName{0, "UNDEFINED"},
    NumberedName{1, "R4G4_UNORM_PACK8"},
    NumberedName{8, "A1R5G5B5_UNORM_PACK16"},
    NumberedName{122, "B10G11R11_UFLOAT_PACK32"},
    NumberedName{123, "E5B9G9R9_UFLOAT_PACK32"},
    NumberedName{124, "D16_UNORM"},
    NumberedName{125, "X8_D24_UNORM_PACK32"},
    NumberedName{126, "D32_SFLOAT"},
    NumberedName{127, "S8_UINT"},
    NumberedName{128, "D16_UNORM_S8_UINT"},
    NumberedName{129, "D24_UNORM_S8_UINT"},
    NumberedName{130, "D32_SFLOAT_S8_UINT"},
    NumberedName{139, "BC4_UNORM_BLOCK"},
    NumberedName{140, "BC4_SNORM_BLOCK"},
    NumberedName{141, "BC5_UNORM_BLOCK"},
    NumberedName{142, "BC5_SNORM_BLOCK"},
    NumberedName{143, "BC6H_UFLOAT_BLOCK"},
    NumberedName{144, "BC6H_SFLOAT_BLOCK"},
};

/// By number.
constexpr std::array<std::string_view, 116> kDxgiNames = {
    "UNKNOWN",
    "R32G32B32A32_TYPELESS",
    "R32G32B32A32_FLOAT",
    "R32G32B32A32_UINT",
    "R32G32B32A32_SINT",
    "R32G32B32_TYPELESS",
    "R32G32B32_FLOAT",
    "R32G32B32_UINT",
    "R32G32B32_SINT",
    "R16G16B16A16_TYPELESS",
    "R16G16B16A16_FLOAT",
    "R16G16B16A16_UNORM",
    "R16G16B16A16_UINT",
    "R16G16B16A16_SNORM",
    "R16G16B16A16_SINT",
    "R32G32_TYPELESS",
    "R32G32_FLOAT",
    "R32G32_UINT",
    "R32G32_SINT",
    "R32G8X24_TYPELESS",
    "D32_FLOAT_S8X24_UINT",
    "R32_FLOAT_X8X24_TYPELESS",
    "X32_TYPELESS_G8X24_UINT",
    "R10G10B10A2_TYPELESS",
    "R10G10B10A2_UNORM",
    "R10G10B10A2_UINT",
    "R11G11B10_FLOAT",
    "R8G8B8A8_TYPELESS",
    "R8G8B8A8_UNORM",
    "R8G8B8A8_UNORM_SRGB",
    "R8G8B8A8_UINT",
    "R8G8B8A8_SNORM",
    "R8G8B8A8_SINT",
    "R16G16_TYPELESS",
    "R16G16_FLOAT",
    "R16G16_UNORM",
    "R16G16_UINT",
    "R16G16_SNORM",
    "R16G16_SINT",
    "R32_TYPELESS",
    "D32_FLOAT",
    "R32_FLOAT",
    "R32_UINT",
    "R32_SINT",
    "R24G8_TYPELESS",
    "D24_UNORM_S8_UINT",
    "R24_UNORM_X8_TYPELESS",
    "X24_TYPELESS_G8_UINT",
    "R8G8_TYPELESS",
    "R8G8_UNORM",
    "R8G8_UINT",
    "R8G8_SNORM",
    "R8G8_SINT",
    "R16_TYPELESS",
    "R16_FLOAT",
    "D16_UNORM",
    "R16_UNORM",
    "R16_UINT",
    "R16_SNORM",
    "R16_SINT",
    "R8_TYPELESS",
    "R8_UNORM",
    "R8_UINT",
    "R8_SNORM",
    "R8_SINT",
    "A8_UNORM",
    "R1_UNORM",
    "R9G9B9E5_SHAREDEXP",
    "R8G8_B8G8_UNORM",
    "G8R8_G8B8_UNORM",
    "BC1_TYPELESS",
    "BC1_UNORM",
    "BC1_UNORM_SRGB",
    "BC2_TYPELESS",
    "BC2_UNORM",
    "BC2_UNORM_SRGB",
    "BC3_TYPELESS",
    "BC3_UNORM",
    "BC3_UNORM_SRGB",
    "BC4_TYPELESS",
    "BC4_UNORM",
    "BC4_SNORM",
    "BC5_TYPELESS",
    "BC5_UNORM",
    "BC5_SNORM",
    "B5G6R5_UNORM",
    "B5G5R5A1_UNORM",
    "B8G8R8A8_UNORM",
    "B8G8R8X8_UNORM",
    "R10G10B10_XR_BIAS_A2_UNORM",
    "B8G8R8A8_TYPELESS",
    "B8G8R8A8_UNORM_SRGB",
    "B8G8R8X8_TYPELESS",
    "B8G8R8X8_UNORM_SRGB",
    "BC6H_TYPELESS",
    "BC6H_UF16",
    "BC6H_SF16",
    "BC7_TYPELESS",
    "BC7_UNORM",
    "BC7_UNORM_SRGB",
    "AYUV",
    "Y410",
    "Y416",
    "NV12",
    "P010",
    "P016",
    "420_OPAQUE",
    "YUY2",
    "Y210",
    "Y216",
    "NV11",
    "AI44",
    "IA44",
    "P8",
    "A8P8",
    "B4G4R4A4_UNORM",
};
static_assert(kDxgiNames[26] == "R11G11B10_FLOAT" && kDxgiNames[67] == "R9G9B9E5_SHAREDEXP" && kDxgiNames[98] == "BC7_UNORM");

constexpr std::uint32_t fourCc(std::string_view text) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(text[i]);
    return value;
}

struct LegacyRow {
    std::uint32_t fourCc;
    std::optional<PixelFormat> format;
    std::string_view name, remedy;
};
constexpr std::string_view kRewrite = "Write it as one of these, for example with texconv -f R8G8B8A8_UNORM, or BC6H_UF16 for light";
constexpr std::string_view kOfBc5 =
    "Tools disagree on the order of its two channels: write it as BC5 (texconv -dx10 -f BC5_UNORM) and look that red and green are right";
constexpr std::string_view kPremultiplied = "Its colours are multiplied by alpha: write it as BC3 (texconv -f BC3_UNORM -alpha)";
constexpr std::array kLegacyRows = {
    LegacyRow{fourCc("DXT1"), PixelFormat::Bc1, "DXT1 (BC1)", ""},
    LegacyRow{fourCc("DXT2"), std::nullopt, "DXT2 (BC2, premultiplied alpha)", kPremultiplied},
    LegacyRow{fourCc("DXT3"), std::nullopt, "DXT3 (BC2)", "Write it as BC3, whose alpha is finer: texconv -f BC3_UNORM"},
    LegacyRow{fourCc("DXT4"), std::nullopt, "DXT4 (BC3, premultiplied alpha)", kPremultiplied},
    LegacyRow{fourCc("DXT5"), PixelFormat::Bc3, "DXT5 (BC3)", ""},
    LegacyRow{fourCc("RXGB"), std::nullopt, "RXGB (BC3 with red in alpha)", "Write it as BC5 (texconv -dx10 -f BC5_UNORM) or BC3"},
    LegacyRow{fourCc("ATI1"), PixelFormat::Bc4, "ATI1 (BC4)", ""},
    LegacyRow{fourCc("BC4U"), PixelFormat::Bc4, "BC4U (BC4)", ""},
    LegacyRow{fourCc("BC4S"), PixelFormat::Bc4Snorm, "BC4S (signed BC4)", ""},
    LegacyRow{fourCc("ATI2"), std::nullopt, "ATI2 (3Dc, an older form of BC5)", kOfBc5},
    LegacyRow{fourCc("A2XY"), std::nullopt, "A2XY (3Dc, an older form of BC5)", kOfBc5},
    LegacyRow{fourCc("BC5U"), PixelFormat::Bc5, "BC5U (BC5)", ""},
    LegacyRow{fourCc("BC5S"), PixelFormat::Bc5Snorm, "BC5S (signed BC5)", ""},
    LegacyRow{fourCc("ETC1"), std::nullopt, "ETC1", kRewrite},
    LegacyRow{fourCc("ETC2"), std::nullopt, "ETC2", kRewrite},
    LegacyRow{fourCc("PTC2"), std::nullopt, "PTC2 (PVRTC)", kRewrite},
    LegacyRow{fourCc("PTC4"), std::nullopt, "PTC4 (PVRTC)", kRewrite},
    LegacyRow{fourCc("UYVY"), std::nullopt, "UYVY (video)", kRewrite},
    LegacyRow{fourCc("YUY2"), std::nullopt, "YUY2 (video)", kRewrite},
    LegacyRow{36, PixelFormat::Rgba16Unorm, "A16B16G16R16", ""},
    LegacyRow{110, std::nullopt, "Q16W16V16U16", kRewrite},
    LegacyRow{111, std::nullopt, "R16F", "Write it as R16G16B16A16_FLOAT: texconv -f R16G16B16A16_FLOAT"},
    LegacyRow{112, std::nullopt, "G16R16F", "Write it as R16G16B16A16_FLOAT: texconv -f R16G16B16A16_FLOAT"},
    LegacyRow{113, PixelFormat::Rgba16f, "A16B16G16R16F", ""},
    LegacyRow{114, std::nullopt, "R32F", "Write it as R16G16B16A16_FLOAT: texconv -f R16G16B16A16_FLOAT"},
    LegacyRow{115, std::nullopt, "G32R32F", "Write it as R16G16B16A16_FLOAT: texconv -f R16G16B16A16_FLOAT"},
    LegacyRow{116, std::nullopt, "A32B32G32R32F", "Write it as R16G16B16A16_FLOAT: texconv -f R16G16B16A16_FLOAT"},
};

}  // namespace

std::string vkFormatName(std::uint32_t vkFormat) {
    for (const VkRun& run : kVkRuns) {
        const std::size_t index = vkFormat - run.first;
        if (vkFormat < run.first || index >= run.channels.size() * run.kinds.size()) continue;
        return fmt::format("VK_FORMAT_{}_{}{} ({})", run.channels[index / run.kinds.size()], run.kinds[index % run.kinds.size()],
                           run.ending, vkFormat);
    }
    const auto other = std::ranges::find(kOtherVkFormats, vkFormat, &NumberedName::number);
    return other == kOtherVkFormats.end() ? fmt::format("{}", vkFormat) : fmt::format("VK_FORMAT_{} ({})", other->name, vkFormat);
}

std::string dxgiFormatName(std::uint32_t dxgiFormat) {
    return dxgiFormat < kDxgiNames.size() ? fmt::format("{} ({})", kDxgiNames[dxgiFormat], dxgiFormat) : fmt::format("{}", dxgiFormat);
}

LegacyDdsFormat legacyDdsFormat(std::uint32_t code) {
    const auto row = std::ranges::find(kLegacyRows, code, &LegacyRow::fourCc);
    if (row != kLegacyRows.end()) return {row->format, std::string(row->name), std::string(row->remedy)};
    std::string letters;
    for (int shift = 0; shift < 32; shift += 8) letters += static_cast<char>(code >> shift & 0xff);
    const bool areLetters = std::ranges::all_of(letters, [](char c) { return c >= ' ' && c <= '~'; });
    return {std::nullopt, areLetters ? letters : fmt::format("{}", code), std::string(kRewrite)};
}

}  // namespace lightcook::formats
