#include "formats/bakes/unreal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <iterator>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "formats/bakes/exit_radiance.h"
#include "formats/epic_light_maps.h"
#include "formats/gltf/epic_extension.h"
#include "formats/plain_image.h"
#include "formats/png.h"

namespace lightcook::formats {
namespace {

constexpr double kBlackPoint = 0.01858136;  ///< 2^-5.75, as the shader has it
constexpr double kFlatDirectionality = 0.6;
constexpr double kResidualStep = 1.0 / 255;
/// Texels of all rectangles, overlaps counted again, as a multiple of the image's.
constexpr std::int64_t kMostOverlap = 16;

/// Texels [x0, x1) x [y0, y1).
struct TexelBox {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

    std::int64_t count() const { return std::int64_t{x1 - x0} * (y1 - y0); }
};

/// Returns the texels of a map whose centres lie in a rectangle of its UVs.
TexelBox boxOf(const glm::dvec4& scaleBias, int width, int height) {
    const auto first = [](double edge, int size) { return static_cast<int>(std::clamp(std::ceil(edge * size - 0.5), 0.0, 1.0 * size)); };
    return {first(scaleBias.z, width), first(scaleBias.w, height), first(scaleBias.z + scaleBias.x, width),
            first(scaleBias.w + scaleBias.y, height)};
}

/// Returns the exit radiance of a texel.
/// colour     R, G, B and A of the upper half
/// direction  of the lower half
glm::vec3 decoded(const glm::vec4& colour, const glm::vec4& direction, const EpicPart& part) {
    const glm::dvec4 stored(colour);
    const double fraction = stored.a + (static_cast<double>(direction.a) - 0.5) * kResidualStep;
    const double luminance = std::max(std::exp2(fraction * part.scale.a + part.add.a) - kBlackPoint, 0.0);
    const glm::dvec3 root(stored);
    const glm::dvec3 chroma = glm::max(root * root * glm::dvec3(part.scale) + glm::dvec3(part.add), glm::dvec3(0));
    return glm::vec3(kFlatDirectionality * luminance * chroma);
}

/// A light map whose light is held in memory.
class UnrealReader final : public BakeReader {
public:
    /// subject  names the image
    UnrealReader(Subject subject, int width, int height)
        : subject_(std::move(subject)), light_(width, height), covered_(width, height, 0) {}

    int width() const override { return light_.width(); }
    int height() const override { return light_.height(); }
    int tileHeight() const override { return kTileExtent; }
    bool hasNormals() const override { return false; }
    bool hasCoverage() const override { return hasCoverage_; }

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw;
        raw.sh = Image<lighting::ShRgb>(width(), rowCount);
        if (hasCoverage_) raw.coverage = Image<float>(width(), rowCount);
        for (int y = 0; y < rowCount; ++y)
            for (int x = 0; x < width(); ++x) {
                raw.sh.at(x, y)[0] = kFirstOfExit * light_.at(x, firstRow + y);
                if (hasCoverage_) raw.coverage.at(x, y) = covered_.at(x, firstRow + y);
            }
        return raw;
    }

    /// Names alpha in the upper half of the image, which stores the logarithm of the light. The other numbers are its colour and direction.
    std::optional<StoredNumber> placeOf(std::size_t, int, int x, int y) const override { return StoredNumber{subject_, "A", x, y}; }

    /// Decodes the texels of a box.
    /// stored  the whole image
    void decode(const Image<glm::vec4>& stored, const TexelBox& box, const EpicPart& part) {
        for (int y = box.y0; y < box.y1; ++y)
            for (int x = box.x0; x < box.x1; ++x) {
                light_.at(x, y) = decoded(stored.at(x, y), stored.at(x, y + height()), part);
                covered_.at(x, y) = 1;
            }
    }
    /// Call it after the last part.
    void finish() { hasCoverage_ = std::ranges::find(covered_.texels(), std::uint8_t{0}) != covered_.texels().end(); }

private:
    Subject subject_;
    Image<glm::vec3> light_;
    Image<std::uint8_t> covered_;
    bool hasCoverage_ = false;
};

/// Returns the parts of an image, each rectangle with its constants once.
std::vector<EpicPart> partsOf(const EpicExtension& extension, std::uint64_t image) {
    std::vector<EpicPart> parts;
    std::ranges::copy_if(extension.parts(), std::back_inserter(parts), [&](const EpicPart& part) { return part.image == image; });
    const auto numbers = [](const EpicPart& part) {
        const glm::dvec4 &uv = part.coordinateScaleBias, &scale = part.scale, &add = part.add;
        return std::tuple(uv.x, uv.y, uv.z, uv.w, scale.x, scale.y, scale.z, scale.w, add.x, add.y, add.z, add.w);
    };
    std::ranges::stable_sort(parts, {}, numbers);
    parts.erase(std::unique(parts.begin(), parts.end(), [&](const auto& a, const auto& b) { return numbers(a) == numbers(b); }),
                parts.end());
    std::ranges::sort(parts, {}, &EpicPart::index);
    return parts;
}

/// Fails where two parts with other constants share a texel.
void checkOverlap(const GltfDocument& document, const std::vector<EpicPart>& parts, int width, int height) {
    std::int64_t count = 0;
    for (const EpicPart& part : parts) count += boxOf(part.coordinateScaleBias, width, height).count();
    if (count > kMostOverlap * width * height)
        document.fail(ErrorCode::WrongShape, kEpicExtension,
                      fmt::format("found rectangles of {} texels in all, expected at most {} times the {} x {} of the light map", count,
                                  kMostOverlap, width, height));
    Image<std::int32_t> owner(width, height, -1);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const TexelBox box = boxOf(parts[i].coordinateScaleBias, width, height);
        for (int y = box.y0; y < box.y1; ++y)
            for (int x = box.x0; x < box.x1; ++x) {
                const int other = std::exchange(owner.at(x, y), static_cast<int>(i));
                if (other < 0) continue;
                const EpicPart& known = parts[static_cast<std::size_t>(other)];
                if (known.scale == parts[i].scale && known.add == parts[i].add) continue;
                document.fail(
                    ErrorCode::WrongShape, fmt::format("{}, {}", kEpicExtension, parts[i].place()),
                    fmt::format("found texel ({}, {}) in a rectangle of {} too, with another lightmapScale or lightmapAdd, expected "
                                "rectangles that share no texel",
                                x, y, known.place()));
            }
    }
}

/// Returns the name of an image in errors.
Subject subjectOf(const GltfDocument& document, std::uint64_t image) {
    return Subject(document.file()).at(fmt::format("image {}", image));
}

/// Returns the image as stored.
PlainImage readStored(const GltfDocument& document, std::uint64_t image) {
    const std::string place = fmt::format("image {}", image);
    Result<PlainImage> stored = decodePng(document.imageBytes(image), subjectOf(document, image));
    if (!stored) throw GltfFault(stored.error());
    if (stored->channelCount < 4)
        document.fail(
            ErrorCode::WrongShape, place,
            fmt::format("found {} channels, expected R, G, B and A: the logarithm of the light is in alpha", stored->channelCount));
    if (stored->texels.height() % 2 != 0)
        document.fail(ErrorCode::WrongShape, place,
                      fmt::format("found a height of {} texels, expected an even one: colours above directions", stored->texels.height()));
    return std::move(*stored);
}

}  // namespace

Result<ExrInfo> unrealContent(const std::filesystem::path& file) {
    return resultOf(file, [&] {
        const GltfDocument document = GltfDocument::withoutBuffers(file);
        if (EpicExtension(document).parts().empty())
            document.fail(ErrorCode::WrongShape, "",
                          fmt::format("found a glTF without light maps of Unreal, expected extension {}. Not from Unreal? Name the image "
                                      "of the light map. From Unreal? Build the lighting, and export with Export Lightmaps on",
                                      kEpicExtension));
        ExrInfo info;
        info.channels = {kEpicExtension};
        return info;
    });
}

BakeMatch matchUnrealHq(const std::filesystem::path&, const ExrInfo& info) {
    constexpr int kNumbers = 3;
    if (!info.has(kEpicExtension)) return {};
    return {BakeMatch::Kind::Certain, kNumbers, fmt::format("extension {} of the glTF", kEpicExtension)};
}

Result<std::unique_ptr<BakeReader>> openUnrealHq(const std::filesystem::path& file, const std::string& image) {
    return resultOf(file, [&]() -> std::unique_ptr<BakeReader> {
        const GltfDocument document(file);
        const EpicExtension extension(document);
        const std::uint64_t chosen = extension.imageNamed(image);
        const PlainImage stored = readStored(document, chosen);
        const int width = stored.texels.width(), height = stored.texels.height() / 2;
        const std::vector<EpicPart> parts = partsOf(extension, chosen);
        checkOverlap(document, parts, width, height);
        auto reader = std::make_unique<UnrealReader>(subjectOf(document, chosen), width, height);
        for (const EpicPart& part : parts) reader->decode(stored.texels, boxOf(part.coordinateScaleBias, width, height), part);
        reader->finish();
        return reader;
    });
}

}  // namespace lightcook::formats
