#include "formats/environment.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <system_error>

#include "formats/exr_file.h"
#include "formats/one_line.h"

namespace formats {
namespace {

constexpr std::int64_t kMostTexels = std::int64_t{1} << 28;  // 4 GiB as RGBA float; the largest panoramas in use are 16k x 8k, half of that
constexpr int kFaceCount = 6;

/// Once a process: no pools of threads behind our back. Each caller brings its own.
void quietImageIo() {
    static std::once_flag once;
    std::call_once(once, [] {
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", -1);  // none; 1 would send every thread's OpenEXR work, light maps included, through one
    });
}

tl::unexpected<Error> unreadable(const std::filesystem::path& file, const std::string& library) {
    return failure(ErrorCode::FileUnreadable, file.string(), fmt::format("found \"{}\", expected a whole image file", oneLine(library)));
}

/// An open image whose size can be believed.
struct OpenedImage {
    std::unique_ptr<OIIO::ImageInput> input;
    int width = 0, height = 0, channelCount = 0;
    std::vector<std::string> channels;
};

Result<OpenedImage> openImage(const std::filesystem::path& file) {
    quietImageIo();
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) {
        return failure(ErrorCode::FileUnreadable, file.string(), "found no such file, expected an image");
    }
    OIIO::ImageSpec hints;
    hints["oiio:UnassociatedAlpha"] = 1;  // colours as the file has them, not multiplied by alpha
    OpenedImage image;
    image.input = OIIO::ImageInput::open(file.string(), &hints);
    if (!image.input) return unreadable(file, OIIO::geterror());
    const OIIO::ImageSpec& spec = image.input->spec();
    image.width = spec.width;
    image.height = spec.height;
    image.channelCount = spec.nchannels;
    image.channels = spec.channelnames;
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 || std::int64_t{spec.width} * spec.height > kMostTexels) {
        return failure(ErrorCode::WrongShape, file.string(),
                       fmt::format("found {} x {} texels of {} channels, expected 1 to {} texels", spec.width, spec.height, spec.nchannels,
                                   kMostTexels));
    }
    if (spec.depth > 1 || spec.deep) {
        return failure(ErrorCode::FormatUnsupported, file.string(), "found a volume or a deep image, expected a flat one");
    }
    if (const int orientation = spec.get_int_attribute("Orientation", 1); orientation != 1) {
        return failure(ErrorCode::FormatUnsupported, file.string(),
                       fmt::format("found texels stored in orientation {}, expected row 0 on top and x to the right (1)", orientation));
    }
    return image;
}

/// Reads channels [begin, end) of every texel, interleaved and packed.
Result<void> readChannels(OpenedImage& image, const std::filesystem::path& file, int begin, int end, float* out) {
    if (image.input->read_image(0, 0, begin, end, OIIO::TypeDesc::FLOAT, out)) return {};
    return unreadable(file, image.input->geterror());
}

int indexOf(const OpenedImage& image, char name) {
    for (int index = 0; index < image.channelCount; ++index) {
        const std::string& found = image.channels[static_cast<std::size_t>(index)];
        if (found.size() == 1 && (found[0] == name || found[0] == name - 'A' + 'a')) return index;
    }
    return -1;
}

/// R, G and B as stored; what else the file has does not matter.
Result<Image<glm::vec3>> readRgb(const std::filesystem::path& file) {
    Result<OpenedImage> image = openImage(file);
    if (!image) return tl::make_unexpected(image.error());
    const std::array<int, 3> rgb = {indexOf(*image, 'R'), indexOf(*image, 'G'), indexOf(*image, 'B')};
    const auto [least, most] = std::minmax_element(rgb.begin(), rgb.end());
    if (*least < 0) {
        return failure(ErrorCode::WrongShape, file.string(),
                       fmt::format("found {} channel{} ({}), expected R, G and B", image->channelCount, image->channelCount == 1 ? "" : "s",
                                   oneLine(fmt::format("{}", fmt::join(image->channels, ", ")))));
    }
    Image<glm::vec3> texels(image->width, image->height);
    if (rgb[1] == rgb[0] + 1 && rgb[2] == rgb[0] + 2) {
        if (const auto read = readChannels(*image, file, rgb[0], rgb[0] + 3, &texels.texels().data()->x); !read)
            return tl::make_unexpected(read.error());
        return texels;
    }
    const std::size_t channelCount = static_cast<std::size_t>(*most - *least + 1);
    std::vector<float> values(texels.texels().size() * channelCount);
    if (const auto read = readChannels(*image, file, *least, *most + 1, values.data()); !read) return tl::make_unexpected(read.error());
    for (std::size_t texel = 0; texel < texels.texels().size(); ++texel) {
        for (std::size_t c = 0; c < 3; ++c) {
            texels.texels()[texel][static_cast<int>(c)] = values[texel * channelCount + static_cast<std::size_t>(rgb[c] - *least)];
        }
    }
    return texels;
}

tl::unexpected<Error> badTexel(const std::filesystem::path& file, int x, int y, int channel, float value, const char* when) {
    const bool finite = std::isfinite(value);
    return failure(finite ? ErrorCode::ValueOutOfRange : ErrorCode::ValueNotFinite,
                   fmt::format("{}, channel {}, texel ({}, {})", file.string(), "RGB"[channel], x, y),
                   fmt::format("found {}{}, expected a {} value", value, when, finite ? "non-negative" : "finite"));
}

/// The first channel that is not light: NaN, infinite or negative; 3 if all are good.
int firstBadChannel(const glm::vec3& texel) {
    for (int channel = 0; channel < 3; ++channel) {
        if (!(texel[channel] >= 0) || !std::isfinite(texel[channel])) return channel;
    }
    return 3;
}

/// Refuses or repairs what is not light, and brings the rest to the working space. Returns the count of repaired texels.
Result<std::int64_t> makeCanonical(Image<glm::vec3>& texels, const std::filesystem::path& file, const EnvironmentOptions& options) {
    const Result<LinearConversion> colors = linearConversion(options.colors);
    if (!colors) return failure(colors.error().code, fmt::format("{}, {}", file.string(), colors.error().subject), colors.error().detail);
    std::int64_t repaired = 0;
    for (int y = 0; y < texels.height(); ++y) {
        for (int x = 0; x < texels.width(); ++x) {
            glm::vec3& texel = texels.at(x, y);
            if (const int channel = firstBadChannel(texel); channel < 3) {
                if (!options.repair) return badTexel(file, x, y, channel, texel[channel], "");
                texel = glm::vec3(0);
                ++repaired;
            }
            if (colors->isIdentity) continue;
            texel = colors->workingFromSource * texel;
            if (const int channel = firstBadChannel(texel); channel < 3) {
                if (!options.repair) return badTexel(file, x, y, channel, texel[channel], " once in the working colour space");
                for (int c = 0; c < 3; ++c) texel[c] = std::isfinite(texel[c]) ? std::max(texel[c], 0.0f) : 0.0f;
                ++repaired;
            }
        }
    }
    return repaired;
}

/// Six faces from left to right, as six faces from top to bottom.
Image<glm::vec3> verticalStrip(const Image<glm::vec3>& horizontal) {
    const int size = horizontal.height();
    Image<glm::vec3> vertical(size, kFaceCount * size);
    for (int face = 0; face < kFaceCount; ++face) {
        for (int y = 0; y < size; ++y) std::copy_n(horizontal.view().row(y) + face * size, size, vertical.view().row(face * size + y));
    }
    return vertical;
}

}  // namespace

Result<LoadedEnvironment> loadEnvironment(const std::filesystem::path& file, const EnvironmentOptions& options) {
    Result<Image<glm::vec3>> texels = readRgb(file);
    if (!texels) return tl::make_unexpected(texels.error());
    const int width = texels->width(), height = texels->height();
    const bool isEquirectangular = width == 2 * height, isVertical = height == kFaceCount * width,
               isHorizontal = width == kFaceCount * height;
    if (!isEquirectangular && !isVertical && !isHorizontal) {
        return failure(ErrorCode::WrongShape, file.string(),
                       fmt::format("found {} x {} texels, expected 2:1 (equirectangular), 1:6 or 6:1 (six cube faces)", width, height));
    }
    // Before the faces move, so that a refusal names the texel of the file.
    const Result<std::int64_t> repaired = makeCanonical(*texels, file, options);
    if (!repaired) return tl::make_unexpected(repaired.error());
    LoadedEnvironment loaded;
    loaded.repairedTexels = *repaired;
    loaded.environment.projection = isEquirectangular ? Environment::Projection::Equirectangular : Environment::Projection::CubeStrip;
    loaded.environment.texels = isHorizontal ? verticalStrip(*texels) : std::move(*texels);
    return loaded;
}

Result<std::vector<glm::vec3>> loadGradient(const std::filesystem::path& file, const EnvironmentOptions& options) {
    Result<Image<glm::vec3>> texels = readRgb(file);
    if (!texels) return tl::make_unexpected(texels.error());
    if (texels->height() != 1) {
        return failure(ErrorCode::WrongShape, file.string(),
                       fmt::format("found {} x {} texels, expected N x 1", texels->width(), texels->height()));
    }
    const Result<std::int64_t> repaired = makeCanonical(*texels, file, options);
    if (!repaired) return tl::make_unexpected(repaired.error());
    return std::move(texels->texels());
}

namespace {

/// Nine RGB from [[r, g, b], ...], or why not.
Result<lighting::ShRgb> shFromJson(const nlohmann::json& rows, const std::string& subject) {
    const std::string expected = "expected nine rows of three finite numbers";
    if (!rows.is_array() || rows.size() != lighting::kShCount) {
        return failure(ErrorCode::WrongShape, subject, fmt::format("found {} rows, {}", rows.is_array() ? rows.size() : 0, expected));
    }
    lighting::ShRgb sh{};
    for (std::size_t i = 0; i < sh.size(); ++i) {
        if (!rows[i].is_array() || rows[i].size() != 3)
            return failure(ErrorCode::WrongShape, subject, fmt::format("found another shape in row {}, {}", i, expected));
        for (int channel = 0; channel < 3; ++channel) {
            const nlohmann::json& value = rows[i][static_cast<std::size_t>(channel)];
            const float number = value.is_number() ? value.get<float>() : NAN;
            if (!std::isfinite(number)) {
                return failure(ErrorCode::ValueNotFinite, subject,
                               fmt::format("found {} in row {}, {}", oneLine(value.dump()), i, expected));
            }
            sh[i][channel] = number;
        }
    }
    return sh;
}

}  // namespace

Result<lighting::ShRgb> loadProbeSh(const std::filesystem::path& json, const std::string& probeFileName) {
    std::ifstream stream(json);
    if (!stream) return failure(ErrorCode::FileUnreadable, json.string(), "found no such file, expected a list of probes in JSON");
    const nlohmann::json document = nlohmann::json::parse(stream, nullptr, false);
    if (document.is_discarded())
        return failure(ErrorCode::FileUnreadable, json.string(), "found text that is not JSON, expected a list of probes");
    if (!document.is_object() || !document.contains("probes") || !document["probes"].is_array()) {
        return failure(ErrorCode::WrongShape, json.string(),
                       "found no array \"probes\", expected one with \"file\" and \"sh\" of each probe");
    }
    const nlohmann::json& probes = document["probes"];
    for (const nlohmann::json& probe : probes) {
        if (!probe.is_object() || !probe.contains("file") || probe["file"] != probeFileName) continue;
        return shFromJson(probe.contains("sh") ? probe["sh"] : nlohmann::json(), fmt::format("{}, sh of {}", json.string(), probeFileName));
    }
    return failure(ErrorCode::WrongShape, json.string(),
                   fmt::format("found {} probes, none with the file \"{}\", expected it", probes.size(), oneLine(probeFileName)));
}

Result<void> writeExr(const std::filesystem::path& file, ImageView<const glm::vec4> texels, int channelCount) {
    assert(1 <= channelCount && channelCount <= 4);
    if (texels.width < 1 || texels.height < 1 || texels.width > kLargestExtent || texels.height > kLargestExtent) {
        return failure(ErrorCode::WrongShape, file.string(),
                       fmt::format("found {} x {} texels, expected 1 to {} a side", texels.width, texels.height, kLargestExtent));
    }
    constexpr std::array<const char*, 4> kNames = {"R", "G", "B", "A"};
    Result<ExrWriter> writer =
        ExrWriter::create(file, texels.width, texels.height, {kNames.begin(), kNames.begin() + channelCount}, ExrLayout::ScanLines);
    if (!writer) return tl::make_unexpected(writer.error());
    std::vector<float> row(static_cast<std::size_t>(texels.width) * static_cast<std::size_t>(channelCount));
    for (int y = 0; y < texels.height; ++y) {
        for (int x = 0; x < texels.width; ++x) {
            for (int channel = 0; channel < channelCount; ++channel)
                row[static_cast<std::size_t>(x * channelCount + channel)] = texels.at(x, y)[channel];
        }
        if (const auto written = writer->append(row.data(), texels.width * channelCount, 1); !written) return written;
    }
    return writer->commit();
}

Result<PlainImage> readImage(const std::filesystem::path& file) {
    Result<OpenedImage> image = openImage(file);
    if (!image) return tl::make_unexpected(image.error());
    PlainImage plain;
    plain.channelCount = image->channelCount;
    plain.texels = Image<glm::vec4>(image->width, image->height, glm::vec4(0, 0, 0, 1));
    const int alpha = image->input->spec().alpha_channel;
    const int readCount = std::min(image->channelCount, 4);
    std::vector<float> values(plain.texels.texels().size() * static_cast<std::size_t>(readCount));
    if (const auto read = readChannels(*image, file, 0, readCount, values.data()); !read) return tl::make_unexpected(read.error());
    const float* next = values.data();
    for (glm::vec4& texel : plain.texels.texels()) {
        for (int channel = 0; channel < readCount; ++channel) texel[channel == alpha ? 3 : channel] = *next++;
    }
    return plain;
}

Result<std::vector<std::byte>> encodePng(ImageView<const glm::u8vec3> texels) {
    quietImageIo();
    const char* const subject = "PNG thumbnail";
    if (texels.width < 1 || texels.height < 1) return failure(ErrorCode::WrongShape, subject, "found no texels, expected some");
    const auto fault = [subject](const std::string& library) {
        return failure(ErrorCode::Internal, subject, fmt::format("found \"{}\" while encoding, expected bytes", oneLine(library)));
    };
    std::vector<unsigned char> encoded;
    OIIO::Filesystem::IOVecOutput sink(encoded);
    const auto output = OIIO::ImageOutput::create("thumbnail.png");
    if (!output) return fault(OIIO::geterror());
    if (!output->set_ioproxy(&sink)) return fault("an encoder that cannot write to memory");
    const OIIO::ImageSpec spec(texels.width, texels.height, 3, OIIO::TypeDesc::UINT8);
    if (!output->open("thumbnail.png", spec)) return fault(output->geterror());
    const auto rowBytes = static_cast<OIIO::stride_t>(texels.rowStride * static_cast<std::ptrdiff_t>(sizeof(glm::u8vec3)));
    if (!output->write_image(OIIO::TypeDesc::UINT8, texels.texels, sizeof(glm::u8vec3), rowBytes) || !output->close())
        return fault(output->geterror());
    const auto bytes = std::as_bytes(std::span(encoded));
    return std::vector<std::byte>(bytes.begin(), bytes.end());
}

}  // namespace formats
