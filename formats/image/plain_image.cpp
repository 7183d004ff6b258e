#include "formats/plain_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "formats/image/exr_file.h"
#include "formats/image/image_claims.h"
#include "formats/image/image_module.h"
#include "formats/image/radiance_file.h"
#include "formats/lower_extension.h"
#include "formats/png.h"

namespace lightcook::formats {
namespace {

constexpr std::array<const char*, 4> kChannels = {"R", "G", "B", "A"};

/// Reads a flat EXR file whose channels are R, RG or RGB, with or without A. Returns nothing for any other file, or one that cannot be
/// read.
std::optional<PlainImage> readRgbaExr(const Result<ExrReader>& reader) {
    if (!reader) return std::nullopt;
    const ExrInfo& info = reader->info();
    if (!info.has("R") || (info.has("B") && !info.has("G")) || !checkExtent(info.width, info.height, 4, 4, "")) return std::nullopt;
    PlainImage image{Image<glm::vec4>(info.width, info.height, glm::vec4(0, 0, 0, 1)), static_cast<int>(info.channels.size())};
    std::vector<ExrPlane> planes;
    for (const std::string& channel : info.channels) {
        const auto target = std::ranges::find(kChannels, channel);
        if (target == kChannels.end()) return std::nullopt;
        float* const first = &image.texels.texels().data()->x + (target - kChannels.begin());
        planes.push_back({channel, first, 4, std::ptrdiff_t{4} * info.width});
    }
    if (!reader->readRows(0, info.height, planes)) return std::nullopt;
    return image;
}

Result<PlainImage> readByOpenImageIo(const std::filesystem::path& file) {
    const auto factors = radianceFactors(file);
    if (!factors) return tl::make_unexpected(factors.error());
    const auto module = imageModule();
    auto image = module ? (*module)->readImage(file) : tl::make_unexpected(module.error());
    if (image && *factors != glm::vec3(1))
        for (glm::vec4& texel : image->texels.texels()) texel /= glm::vec4(*factors, 1);
    return image;
}

}  // namespace

bool isPictureFile(const std::filesystem::path& file) {
    const std::string extension = lowerExtension(file);
    for (const char* each : {".png", ".jpg", ".jpeg", ".tga", ".bmp"})
        if (extension == each) return true;
    return false;
}

Result<PlainImage> readImage(const std::filesystem::path& file) {
    if (auto picture = readRadiancePicture(file)) {
        PlainImage image{Image<glm::vec4>(picture->width(), picture->height()), 3};
        std::ranges::transform(picture->texels(), image.texels.texels().begin(),
                               [](const glm::vec3& colour) { return glm::vec4(colour, 1); });
        return image;
    }
    const Result<ExrReader> exr = ExrReader::open(file);
    if (const auto believable = checkClaims(file, exr); !believable) return tl::make_unexpected(believable.error());
    if (auto image = readRgbaExr(exr)) return std::move(*image);
    return isPngFile(file) ? readPng(file) : readByOpenImageIo(file);
}

Result<void> writeExr(const std::filesystem::path& file, ImageView<const glm::vec4> texels, int channelCount) {
    assert(1 <= channelCount && channelCount <= 4);
    if (texels.width < 1 || texels.height < 1 || texels.width > kLargestExtent || texels.height > kLargestExtent) {
        return failure(ErrorCode::WrongShape, file.string(),
                       fmt::format("found {} x {} texels, expected 1 to {} a side", texels.width, texels.height, kLargestExtent));
    }
    Result<ExrWriter> writer =
        ExrWriter::create(file, texels.width, texels.height, {kChannels.begin(), kChannels.begin() + channelCount}, ExrLayout::ScanLines);
    if (!writer) return tl::make_unexpected(writer.error());
    std::vector<float> row(static_cast<std::size_t>(texels.width) * static_cast<std::size_t>(channelCount));
    for (int y = 0; y < texels.height; ++y) {
        for (int x = 0; x < texels.width; ++x) {
            for (int channel = 0; channel < channelCount; ++channel)
                row[static_cast<std::size_t>(x * channelCount + channel)] = texels.at(x, y)[channel];
        }
        if (auto written = writer->append(row.data(), texels.width * channelCount, 1); !written) return written;
    }
    return writer->commit();
}

}  // namespace lightcook::formats
