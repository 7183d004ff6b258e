#include "formats/bakes/bake_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "formats/bakes/bake_reader.h"
#include "formats/bakes/light_encoding.h"
#include "formats/bakes/surface_channels.h"
#include "formats/digest.h"
#include "formats/file/file_kind.h"
#include "formats/gpu_texture.h"
#include "formats/lower_extension.h"
#include "formats/plain_image.h"

namespace lightcook::formats {
namespace {

constexpr std::string_view kColours = "RGB";
const std::string kGrey = "Y";

struct Picture {
    Image<glm::vec3> colours;
    Image<float> alpha;  ///< empty: there is none
    std::optional<StatedChromaticities> chromaticities = {};
};

Result<Picture> readPicture(const std::filesystem::path& file) {
    if (const auto found = whyNoFile(file))
        return failure(ErrorCode::FileUnreadable, file, fmt::format("found {}, expected an image", *found));
    const Result<PlainImage> image = readImage(file);
    if (!image) return tl::make_unexpected(image.error());
    const auto& texels = image->texels;
    const auto isGrey = [](const glm::vec4& texel) { return texel.x == texel.y && texel.x == texel.z; };
    if (image->channelCount == 2 && !std::ranges::all_of(texels.texels(), isGrey))
        return failure(ErrorCode::WrongShape, file, "found two channels, expected R, G and B, or grey");
    Picture picture{Image<glm::vec3>(texels.width(), texels.height()), {}, image->chromaticities};
    std::ranges::transform(texels.texels(), picture.colours.texels().begin(), [](const glm::vec4& texel) { return glm::vec3(texel); });
    constexpr int kGreyWithAlpha = 2;
    if (image->channelCount > 3 || image->channelCount == kGreyWithAlpha) {
        picture.alpha = Image<float>(texels.width(), texels.height());
        std::ranges::transform(texels.texels(), picture.alpha.texels().begin(), [](const glm::vec4& texel) { return texel.a; });
    }
    return picture;
}

/// Returns true if an image has Y in place of R, G and B.
bool isGreyImage(const ExrInfo& info) {
    return info.has(kGrey) && std::ranges::all_of(info.channels, [](const std::string& name) {
               return name == kGrey || name == "A" || std::ranges::find(kSurfaceChannels, name) != kSurfaceChannels.end();
           });
}

/// Reads rows of an image that has Y in place of R, G and B. OpenEXR reads a channel to one place.
Result<void> readGreyRows(const ExrReader& exr, int firstRow, int rowCount, std::span<const ExrPlane> planes) {
    for (const ExrPlane& plane : planes) {
        ExrPlane read = plane;
        if (plane.channel.size() == 1 && kColours.find(plane.channel) != std::string_view::npos) read.channel = kGrey;
        LC_CHECK(exr.readRows(firstRow, rowCount, {&read, 1}));
    }
    return {};
}

}  // namespace

Result<BakeImage> BakeImage::open(const std::filesystem::path& file) {
    const std::string extension = lowerExtension(file);
    if (extension == ".hdr" || extension == ".pic") return openPicture(file);
    Result<ExrReader> exr = ExrReader::open(file);
    if (!exr && !whyNoFile(file) && isPictureFile(file))
        return failure(
            ErrorCode::FormatUnsupported, file,
            "found a picture of integers, expected OpenEXR or Radiance HDR, or its encoding: \"none\" of linear values, \"srgb\" of "
            "display colours, \"rgbm\" or \"dldr\" of Unity. Set encoding (--encoding)");
    if (!exr) return tl::make_unexpected(textureForImage(file, "OpenEXR or Radiance HDR").value_or(exr.error()));
    BakeImage image(file);
    image.exr_ = std::move(*exr);
    return image;
}

Result<BakeImage> BakeImage::openAs(const std::filesystem::path& file, LightEncoding encoding) {
    switch (encoding) {
        case LightEncoding::Auto:
            return open(file).map(withColours);
        case LightEncoding::None:
            return openAny(file);
        case LightEncoding::Rgbm:
        case LightEncoding::Dldr:
        case LightEncoding::Srgb:
            break;
    }
    return openEncoded(file, encoding);
}

BakeImage BakeImage::withColours(BakeImage image) {
    if (!image.exr_ || !isGreyImage(image.exr_->info())) return image;
    image.isGrey_ = true;
    image.pictureInfo_ = image.exr_->info();
    std::erase(image.pictureInfo_.channels, kGrey);
    for (const char* const colour : {"B", "G", "R"}) image.pictureInfo_.channels.emplace_back(colour);
    return image;
}

Result<BakeImage> BakeImage::openAny(const std::filesystem::path& file) {
    return lowerExtension(file) == ".exr" ? open(file).map(withColours) : openPicture(file);
}

Result<BakeImage> BakeImage::openEncoded(const std::filesystem::path& file, LightEncoding encoding) {
    const std::string_view name = nameOfConvention(encoding);
    const std::string extension = lowerExtension(file);
    if (extension == ".exr" || extension == ".hdr" || extension == ".pic")
        return failure(ErrorCode::InvalidRequest, file,
                       fmt::format("found HDR values, expected an 8-bit picture (PNG, TGA): encoding is \"{}\". Remove that key", name));
    Result<BakeImage> image = openPicture(file);
    if (!image) return image;
    const bool hasAlpha = image->alpha_.width() > 0;
    if (encoding == LightEncoding::Rgbm && !hasAlpha)
        return failure(ErrorCode::WrongShape, file,
                       "found no alpha, expected the multiplier of RGBM in it. Double LDR? Set encoding = \"dldr\"");
    for (int y = 0; y < image->picture_.height(); ++y)
        for (int x = 0; x < image->picture_.width(); ++x) {
            glm::vec3& colour = image->picture_.at(x, y);
            const glm::vec4 stored(colour, hasAlpha ? image->alpha_.at(x, y) : 1);
            for (int c = 0; c < 4; ++c)
                if (!(stored[c] >= 0 && stored[c] <= 1))
                    return failure(ErrorCode::ValueOutOfRange, Subject(file).at(fmt::format("channel {}, texel ({}, {})", "RGBA"[c], x, y)),
                                   fmt::format("found {}, expected 0 to 1 under encoding = \"{}\"", stored[c], name));
            colour = decodedLight(stored, encoding);
        }
    if (encoding == LightEncoding::Rgbm) {  // alpha was a part of the light, not coverage
        image->alpha_ = {};
        image->pictureInfo_.channels = {"B", "G", "R"};
    }
    image->isEncoded_ = true;
    return image;
}

Result<BakeImage> BakeImage::openPicture(const std::filesystem::path& file) {
    BakeImage image(file);
    Result<Picture> picture = readPicture(file);
    if (!picture) return tl::make_unexpected(picture.error());
    image.picture_ = std::move(picture->colours);
    image.alpha_ = std::move(picture->alpha);
    image.pictureInfo_.chromaticities = picture->chromaticities;
    image.pictureInfo_.width = image.picture_.width();
    image.pictureInfo_.height = image.picture_.height();
    if (image.alpha_.width() > 0)
        image.pictureInfo_.channels = {"A", "B", "G", "R"};
    else
        image.pictureInfo_.channels = {"B", "G", "R"};
    return image;
}

int BakeImage::tileHeight() const {
    return info().isTiled ? info().tileHeight : kTileExtent;
}

Result<void> BakeImage::readRows(int firstRow, int rowCount, std::span<const ExrPlane> planes) const {
    if (exr_ && !isGrey_) return exr_->readRows(firstRow, rowCount, planes);
    if (exr_) return readGreyRows(*exr_, firstRow, rowCount, planes);
    for (const ExrPlane& plane : planes) {
        const bool isAlpha = plane.channel == "A";
        const int channel = isAlpha ? 0 : static_cast<int>(kColours.find(plane.channel));
        for (int y = 0; y < rowCount; ++y)
            for (int x = 0; x < picture_.width(); ++x)
                plane.texels[x * plane.texelStride + y * plane.rowStride] =
                    isAlpha ? alpha_.at(x, firstRow + y) : picture_.at(x, firstRow + y)[channel];
    }
    return {};
}

Result<std::string> BakeImage::storedDigest(int firstRow, int rowCount) const {
    if (exr_) return exr_->storedDigest(firstRow, rowCount);
    Digest digest;
    const auto addRows = [&](const auto& image) {
        if (image.width() == 0) return;
        const auto rows = image.view().rows(firstRow, rowCount);
        digest.add(std::span(rows.texels, static_cast<std::size_t>(rows.width) * static_cast<std::size_t>(rows.height)));
    };
    const StatedChromaticities chromaticities = pictureInfo_.chromaticities.value_or(StatedChromaticities());
    digest.add(std::span(chromaticities));
    addRows(picture_);
    addRows(alpha_);
    return digest.text();
}

bool isPicture(const ExrInfo& info) {
    constexpr std::array<std::string_view, 4> kNames = {"R", "G", "B", "A"};
    const bool isOther = std::ranges::any_of(info.channels, [&](const std::string& name) {
        return std::ranges::find(kNames, name) == kNames.end() && std::ranges::find(kSurfaceChannels, name) == kSurfaceChannels.end();
    });
    return !isOther && std::ranges::all_of(kColours, [&](char colour) { return info.has(std::string(1, colour)); });
}

Result<std::vector<BakeImage>> openImages(BakeImage image, std::span<const std::filesystem::path> files) {
    std::vector<BakeImage> images;
    const std::filesystem::path own = image.file();
    if (image.isEncoded() && own != files.front())
        return failure(ErrorCode::InvalidRequest, image.subject(),
                       fmt::format("found a direction map, expected the file with the encoded colours: name {} instead",
                                   files.front().filename().string()));
    std::optional<BakeImage> open = std::move(image);
    for (const std::filesystem::path& file : files) {
        const bool isOpen = open && file == own;
        Result<BakeImage> opened = isOpen ? Result<BakeImage>(*std::exchange(open, std::nullopt)) : BakeImage::openAny(file);
        if (!opened) return tl::make_unexpected(opened.error());
        for (const char colour : kColours)
            if (!opened->info().has(std::string(1, colour)))
                return failure(ErrorCode::WrongShape, opened->subject(), fmt::format("found no channel {}, expected R, G and B", colour));
        images.push_back(std::move(*opened));
        const ExrInfo &first = images.front().info(), &info = images.back().info();
        if (info.width != first.width || info.height != first.height)
            return failure(ErrorCode::WrongShape, images.back().subject(),
                           fmt::format("found {} x {} texels, expected {} x {} as {} has", info.width, info.height, first.width,
                                       first.height, images.front().file().filename().string()));
    }
    return images;
}

}  // namespace lightcook::formats
