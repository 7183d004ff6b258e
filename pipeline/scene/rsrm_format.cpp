#include "pipeline/scene/rsrm_format.h"

#include <algorithm>
#include <array>

#include "formats/vocabulary.h"

namespace lightcook::pipeline {
namespace {

using formats::PixelFormat;
using verify::RsrmCodes;

constexpr std::array kFormats = {
    RsrmFormatInfo{RsrmFormat::Rgba8, "rgba8", "8 bits a channel", PixelFormat::Rgba8Unorm, RsrmCodes::Rounded, false},
    RsrmFormatInfo{RsrmFormat::Bc7, "bc7", "a quarter of the bytes of rgba8", PixelFormat::Bc7, RsrmCodes::Blocks, false},
    RsrmFormatInfo{RsrmFormat::Bc4, "bc4", "an eighth of the bytes of rgba8, for gradients of one colour", PixelFormat::Bc4,
                   RsrmCodes::Blocks, false},
    RsrmFormatInfo{RsrmFormat::Bc6h, "bc6h", "floats in blocks, a quarter of the bytes of rgba8", PixelFormat::Bc6hUf16,
                   RsrmCodes::HalfBlocks, true},
    RsrmFormatInfo{RsrmFormat::Rgb9e5, "rgb9e5", "floats of a shared exponent, the bytes of rgba8", PixelFormat::Rgb9e5,
                   RsrmCodes::SharedExponent, true},
    RsrmFormatInfo{RsrmFormat::Rgba16f, "rgba16f", "halves, twice the bytes of rgba8", PixelFormat::Rgba16f, RsrmCodes::Halves, true},
};
static_assert(formats::isCompleteTable(kFormats, RsrmFormat::Rgba16f));

}  // namespace

std::span<const RsrmFormatInfo> allRsrmFormats() {
    return kFormats;
}

const RsrmFormatInfo& info(RsrmFormat format) {
    return kFormats.at(static_cast<std::size_t>(format));
}

const RsrmFormatInfo* rsrmFormatFromName(std::string_view name) {
    return formats::findByName(allRsrmFormats(), name);
}

const RsrmFormatInfo* rsrmFormatOf(PixelFormat pixels) {
    const auto found = std::ranges::find(kFormats, pixels, &RsrmFormatInfo::pixels);
    return found == kFormats.end() ? nullptr : &*found;
}

std::vector<std::string> rsrmFormatChoices() {
    std::vector<std::string> names = formats::namesOf(allRsrmFormats());
    names.emplace_back(kAutoRsrmFormat);
    return names;
}

std::vector<std::string> rsrmFormatsToTry(std::string_view asked, formats::Target target, int width, int rowCount) {
    if (!asked.empty() && asked != kAutoRsrmFormat) return {std::string(asked)};
    std::vector<RsrmFormatInfo> formats;
    for (const RsrmFormatInfo& each : kFormats)
        if (each.isFor(target)) formats.push_back(each);
    std::ranges::stable_sort(formats, {}, [&](const RsrmFormatInfo& each) { return formats::bytesPerImage(each.pixels, width, rowCount); });
    std::vector<std::string> names;
    if (asked.empty()) names.emplace_back(info(RsrmFormat::Rgba8).name);
    for (const RsrmFormatInfo& each : formats)
        if (!asked.empty() || each.id != RsrmFormat::Rgba8) names.emplace_back(each.name);
    return names;
}

}  // namespace lightcook::pipeline
