#include "formats/plain_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "formats/image/bmp.h"
#include "formats/image/envmap.h"
#include "formats/image/exr_colours.h"
#include "formats/image/exr_file.h"
#include "formats/image/image_claims.h"
#include "formats/image/image_module.h"
#include "formats/image/radiance_file.h"
#include "formats/lower_extension.h"
#include "formats/png.h"

namespace lightcook::formats {
namespace {

constexpr std::array<const char*, 4> kChannels = {"R", "G", "B", "A"};

Result<PlainImage> readExr(const ExrReader& reader, const std::filesystem::path& file) {
    const ExrInfo& info = reader.info();
    LC_CHECK(checkExtent(info.width, info.height, 4, 4, file));
    Result<ExrColours> colours = exrColours(info, file);
    if (!colours) return tl::make_unexpected(colours.error());
    PlainImage image{.texels = Image<glm::vec4>(info.width, info.height, glm::vec4(0, 0, 0, 1)),
                     .channelCount = colours->channelCount(),
                     .hasAlpha = !colours->channels[3].empty(),
                     .ignored = std::move(colours->ignored),
                     .chromaticities = info.chromaticities,
                     .environment = info.environment};
    std::vector<ExrPlane> planes;
    for (std::size_t i = 0; i < kChannels.size(); ++i)
        if (!colours->channels[i].empty())
            planes.push_back({colours->channels[i], &image.texels.texels().data()->x + i, 4, std::ptrdiff_t{4} * info.width});
    LC_CHECK(reader.readRows(0, info.height, planes));
    if (colours->isGrey)
        for (glm::vec4& texel : image.texels.texels()) texel.y = texel.z = texel.x;
    return image;
}

/// Returns true for a TGA whose header says that no bit of a texel is alpha. Its fourth byte is of no meaning then.
bool isTgaWithoutAlpha(const std::filesystem::path& file) {
    constexpr std::size_t kHeaderBytes = 18, kBitsAt = 16, kDescriptorAt = 17;
    std::array<std::uint8_t, kHeaderBytes> header{};
    if (lowerExtension(file) != ".tga" || !std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(header.data()), kHeaderBytes))
        return false;
    return header[kBitsAt] == 32 && (header[kDescriptorAt] & 15) == 0;
}

Result<PlainImage> readByOpenImageIo(const std::filesystem::path& file) {
    LC_TRY(factors, radianceFactors(file));
    auto image = readImageByModule(file);
    if (image && *factors != glm::vec3(1))
        for (glm::vec4& texel : image->texels.texels()) texel /= glm::vec4(*factors, 1);
    if (image && image->hasAlpha && isTgaWithoutAlpha(file)) {
        for (glm::vec4& texel : image->texels.texels()) texel.a = 1;
        image->hasAlpha = false;
        --image->channelCount;
    }
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
        const Image<glm::vec3>& read = picture->texels;
        PlainImage image{
            .texels = Image<glm::vec4>(read.width(), read.height()), .channelCount = 3, .chromaticities = picture->chromaticities};
        std::ranges::transform(read.texels(), image.texels.texels().begin(), [](const glm::vec3& colour) { return glm::vec4(colour, 1); });
        return image;
    }
    const Result<ExrReader> exr = ExrReader::open(file);
    LC_CHECK(checkClaims(file, exr));
    if (exr) return readExr(*exr, file);
    if (isPngFile(file)) return readPng(file);
    if (auto bitmap = readMaskedBmp(file)) return std::move(*bitmap);
    return readByOpenImageIo(file);
}

Result<void> resampleEnvironment(PlainImage& image, const Subject& subject) {
    if (!image.environment) return {};
    LC_CHECK(checkEnvironmentShape(image.texels.width(), image.texels.height(), *image.environment, subject));
    image.texels = fromExrEnvironment(image.texels, *image.environment);
    image.environment.reset();
    return {};
}

Result<ExrContent> exrContent(const std::filesystem::path& file) {
    return ExrReader::open(file).map([](const ExrReader& reader) {
        return ExrContent{reader.info().width, reader.info().height, reader.info().channels};
    });
}

Result<void> writeExr(const std::filesystem::path& file, ImageView<const glm::vec4> texels, int channelCount) {
    assert(1 <= channelCount && channelCount <= 4);
    if (texels.width < 1 || texels.height < 1 || texels.width > kLargestExtent || texels.height > kLargestExtent) {
        return failure(ErrorCode::WrongShape, file,
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
        LC_CHECK(writer->append(row.data(), texels.width * channelCount, 1));
    }
    return writer->commit();
}

}  // namespace lightcook::formats
