#include "formats/bakes/sh_baker.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "formats/bakes/file_set.h"
#include "formats/bakes/images_reader.h"
#include "formats/bakes/sh_channels.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;

constexpr std::string_view kName = "sh-baker";
constexpr std::span kSplit = std::span(kShBakerEndings).first<9>();
constexpr std::span kPacked = std::span(kShBakerEndings).last<3>();
constexpr int kPackedNumbers = 11;  ///< three of L0, and eight luminances
/// Weights of the luminance that the baker packs.
constexpr glm::vec3 kPackedLuminance{0.2126f, 0.7152f, 0.0722f};

std::string channelOf(std::size_t coefficient, std::size_t colour) {
    return fmt::format("{}.{}", kSplit[coefficient].substr(1), "RGB"[colour]);
}

std::vector<std::string> shBakerChannels() {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < kSplit.size(); ++i)
        for (std::size_t colour = 0; colour < 3; ++colour) names.push_back(channelOf(i, colour));
    return names;
}

/// Returns the colour of a texel's luminances, which its first coefficient has. Luminances beside a black one are light that is lost; as
/// grey they are bands without sh00, which are refused or repaired like those of any bake format.
/// packed  the red of each other coefficient holds its luminance
glm::vec3 packedColour(const ShRgb& packed) {
    constexpr float kRounding = 1e-6f;  // of halves
    const float luminance = glm::dot(packed[0], kPackedLuminance);
    if (luminance > 0) return packed[0] / luminance;
    const auto isLit = [](const glm::vec3& coefficient) { return std::abs(coefficient.x) > kRounding; };
    return glm::vec3(std::any_of(packed.begin() + 1, packed.end(), isLit) ? 1.0f : 0.0f);
}

/// Reads the three packed files.
class PackedReader final : public ImagesReader {
public:
    PackedReader(std::vector<BakeImage> images, SurfaceChannels surface) : ImagesReader(std::move(images), std::move(surface)) {}

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw = emptyStrip(rowCount);
        std::array<std::vector<ExrPlane>, kPacked.size()> planes;
        addColours(raw, 0, planes[0]);
        // A luminance is read to the red of its coefficient.
        for (std::size_t i = 0; i < 8; ++i) planes.at(1 + i / 4).push_back(planeOf(raw, std::string(1, "RGBA"[i % 4]), 3 * (i + 1)));
        addSurface(raw, planes[0]);
        for (std::size_t i = 0; i < images().size(); ++i) LC_CHECK(images()[i].readRows(firstRow, rowCount, planes.at(i)));
        for (ShRgb& sh : raw.sh.texels()) {
            const glm::vec3 colour = packedColour(sh);
            for (std::size_t i = 1; i < sh.size(); ++i) sh[i] = sh[i].x * colour;
        }
        return raw;
    }

private:
    ChannelOfImage sourceOf(std::size_t coefficient, int colour) const override {
        if (coefficient == 0) return {0, colourName(colour)};
        return {1 + (coefficient - 1) / 4, std::string(1, "RGBA"[(coefficient - 1) % 4])};
    }
};

Result<std::unique_ptr<BakeReader>> openPacked(BakeImage image) {
    const auto files = filesOfSet(image.file(), kPacked);
    Result<std::vector<BakeImage>> images = openImages(std::move(image), files);
    if (!images) return tl::make_unexpected(images.error());
    for (std::size_t i = 1; i < images->size(); ++i)
        if (!(*images)[i].info().has("A"))
            return failure(ErrorCode::WrongShape, (*images)[i].subject(), "found no channel A, expected four luminances in R, G, B and A");
    Result<SurfaceChannels> surface = SurfaceChannels::of(images->front());
    if (!surface) return tl::make_unexpected(surface.error());
    return std::make_unique<PackedReader>(std::move(*images), std::move(*surface));
}

Result<std::unique_ptr<BakeReader>> openSplit(BakeImage image) {
    const auto files = filesOfSet(image.file(), kSplit);
    Result<std::vector<BakeImage>> images = openImages(std::move(image), files);
    if (!images) return tl::make_unexpected(images.error());
    std::vector<ShChannel> numbers;
    for (std::size_t i = 0; i < kSplit.size(); ++i)
        for (const char colour : {'R', 'G', 'B'}) numbers.push_back({i, std::string(1, colour)});
    return openShChannels(std::move(*images), std::move(numbers));
}

}  // namespace

BakeMatch matchShBaker(const std::filesystem::path& file, const ExrInfo& info) {
    BakeMatch whole = matchChannels(info, shBakerChannels(), kName, "L0.R .. L22.B");
    if (whole.kind != BakeMatch::Kind::None) return whole;
    if (!isPicture(info)) return {};
    if (const auto files = filesOfSet(file, kSplit); !files.empty())
        return matchFiles(file, files, 3 * lighting::kShCount, kName, FileKinds::Same);
    if (const auto files = filesOfSet(file, kPacked); !files.empty())
        return matchFiles(file, files, kPackedNumbers, kName, FileKinds::Same);
    return {};
}

std::vector<std::filesystem::path> filesBesideShBaker(const std::filesystem::path& file) {
    std::vector<std::filesystem::path> files = filesOfSet(file, kSplit);
    return files.empty() ? filesOfSet(file, kPacked) : files;
}

Result<std::unique_ptr<BakeReader>> openShBaker(BakeImage image) {
    if (isPicture(image.info()))
        return filesOfSet(image.file(), kSplit).empty() ? openPacked(std::move(image)) : openSplit(std::move(image));
    return openShChannels(std::move(image), shBakerChannels());
}

}  // namespace lightcook::formats
