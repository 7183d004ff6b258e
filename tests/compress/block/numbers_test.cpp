// Blocks of several colours, searched for the one that errs most beside one colour.
#include "tests/compress/against_one_colour.h"
#include "tests/lighting/worst_search.h"

namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;
using lightcook::test::SearchBudget;
using lightcook::test::SearchRange;

bool isOfAstc(PixelFormat format) {
    return format == PixelFormat::Astc4x4Ldr || format == PixelFormat::Astc4x4Hdr;
}
/// Returns how many times the error of one colour a block may have: libastcenc has a metric of its own for HDR.
double timesOneColour(PixelFormat format) {
    return format == PixelFormat::Astc4x4Hdr ? 3 : 1;
}
/// Searches all texels and weights, 0 to 3, of a block. libastcenc knows no weights.
void searchBlock(PixelFormat format, int level, const SearchBudget& budget) {
    const formats::PixelFormatInfo& info = formats::info(format);
    const auto channels = static_cast<std::size_t>(info.isFloat ? 3 : info.channelCount);
    std::vector<SearchRange> ranges(channels * kTexelCount, info.isFloat ? SearchRange{1e-9, 65504, SearchRange::Kind::Signed}
                                                                         : SearchRange{0, 1, SearchRange::Kind::Linear});
    if (!isOfAstc(format)) ranges.insert(ranges.end(), kTexelCount, {0, 3, SearchRange::Kind::Linear});
    HostileImage image{TexelImage(4, 4), formats::Image<float>(4, 4), effort(level)};
    lightcook::test::expectHolds(
        std::string(info.name) + " at effort " + std::to_string(level) + ", no worse than " +
            std::to_string(static_cast<int>(timesOneColour(format))) + " times one colour",
        ranges, budget, [&](const std::vector<double>& in) {
            for (std::size_t t = 0; t < kTexelCount; ++t) {
                const int x = static_cast<int>(t) % 4, y = static_cast<int>(t) / 4;
                image.texels.at(x, y) = glm::vec4(0, 0, 0, 1);
                for (std::size_t c = 0; c < channels; ++c)
                    image.texels.at(x, y)[static_cast<int>(c)] = static_cast<float>(in[channels * t + c]);
                const std::size_t weight = channels * kTexelCount + t;
                image.significance.at(x, y) = weight < in.size() ? static_cast<float>(std::round(in[weight])) / 3 : 1;
            }
            const TexelImage decoded = encode(format, image.texels, image.options, image.significance.view()).decoded;
            const AgainstOneColour found =
                info.isFloat ? againstOneLight(format, image, decoded, 0, 0) : againstOneColour(format, image, decoded, 0, 0);
            return found.error == 0 ? 0 : found.error / (timesOneColour(format) * mostOf(found.oneColour, Weights::Few));
        });
}

class BlockNumbers : public testing::TestWithParam<PixelFormat> {};
TEST_P(BlockNumbers, SeveralColoursErrAsStated) {
    for (const int level : {0, 3}) searchBlock(GetParam(), level, {isOfAstc(GetParam()) ? 20 : 200});
}
using BlockNumbersSoak = BlockNumbers;
TEST_P(BlockNumbersSoak, SeveralColoursErrAsStated) {
    constexpr std::array kEfforts = {0, 1, 2, 3, 5, 7, 9};
    for (const int level : kEfforts) searchBlock(GetParam(), level, lightcook::test::soakBudget(static_cast<int>(kEfforts.size())));
}
const auto kSearchedFormats = testing::Values(PixelFormat::Bc1, PixelFormat::Bc3, PixelFormat::Bc4, PixelFormat::Bc5, PixelFormat::Bc6hUf16,
                                              PixelFormat::Bc6hSf16, PixelFormat::Bc7, PixelFormat::Astc4x4Ldr, PixelFormat::Astc4x4Hdr);
const auto nameOfSearched = [](const testing::TestParamInfo<PixelFormat>& instance) {
    std::string name(formats::info(instance.param).name);
    std::ranges::replace(name, '-', '_');
    return name;
};
INSTANTIATE_TEST_SUITE_P(Formats, BlockNumbers, kSearchedFormats, nameOfSearched);
INSTANTIATE_TEST_SUITE_P(Formats, BlockNumbersSoak, kSearchedFormats, nameOfSearched);

}  // namespace
}  // namespace lightcook::compress::test
