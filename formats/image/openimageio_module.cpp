// The module: everything that needs OpenImageIO, and nothing else. Linked into no program; image_module.cpp loads it at first use.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <mutex>

#include "formats/file/file_kind.h"
#include "formats/file/one_line.h"
#include "formats/image/exr_windows.h"
#include "formats/image/image_claims.h"
#include "formats/image/image_module.h"
#include "formats/lower_extension.h"

namespace lightcook::formats {
namespace {

/// Turns off the thread pools of OpenImageIO and OpenEXR, once a process. Callers have threads of their own.
void quietImageIo() {
    static std::once_flag once;
    std::call_once(once, [] {
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", -1);  // none; 1 would send every thread's OpenEXR work, light maps included, through one
    });
}

tl::unexpected<Error> unreadable(const std::filesystem::path& file, const std::string& library) {
    return failure(ErrorCode::FileUnreadable, file.string(), fmt::format("found {}, expected a whole image file", quotedLine(library)));
}

/// Returns true if a format of OpenImageIO has this extension. A file of another one is opened if its content is that of an image.
bool isImageExtension(const std::string& extension) {
    return std::ranges::any_of(OIIO::get_extension_map(), [&](const auto& format) {
        return std::ranges::any_of(format.second, [&](const std::string& each) { return "." + each == extension; });
    });
}

tl::unexpected<Error> unopened(const std::filesystem::path& file) {
    const std::string library = OIIO::geterror(), extension = lowerExtension(file);
    if (isImageExtension(extension)) return unreadable(file, library);
    return failure(ErrorCode::FileUnreadable, file.string(),
                   fmt::format("found a file {}, whose content is no image, expected an image such as .exr, .hdr or .png",
                               extension.empty() ? "without an extension" : "of the extension '" + oneLine(extension) + "'"));
}

/// An open image whose size has been checked.
struct OpenedImage {
    std::unique_ptr<OIIO::ImageInput> input;
    int width = 0, height = 0, channelCount = 0;
    std::vector<std::string> channels;
};

Result<OpenedImage> openImage(const std::filesystem::path& file) {
    if (const auto found = whyNoFile(file))
        return failure(ErrorCode::FileUnreadable, file.string(), fmt::format("found {}, expected an image", *found));
    quietImageIo();
    OIIO::ImageSpec hints;
    hints["oiio:UnassociatedAlpha"] = 1;  // colours as the file has them, not multiplied by alpha
    OpenedImage image;
    image.input = OIIO::ImageInput::open(file.string(), &hints);
    if (!image.input) return unopened(file);
    const OIIO::ImageSpec& spec = image.input->spec();
    image.width = spec.width;
    image.height = spec.height;
    image.channelCount = spec.nchannels;
    image.channels = spec.channelnames;
    if (const auto believable = checkExtent(spec.width, spec.height, spec.nchannels, kFloatsThroughLibrary, file.string()); !believable)
        return tl::make_unexpected(believable.error());
    if (spec.depth > 1 || spec.deep) {
        return failure(ErrorCode::FormatUnsupported, file.string(), "found a volume or a deep image, expected a flat one");
    }
    if (const int orientation = spec.get_int_attribute("Orientation", 1); orientation != 1) {
        return failure(ErrorCode::FormatUnsupported, file.string(),
                       fmt::format("found texels stored in orientation {}, expected row 0 on top and x to the right (1)", orientation));
    }
    if (image.input->format_name() == std::string("openexr")) {  // the windows of other formats may differ: a PNG may have an offset
        const ExrWindow data{spec.x, spec.y, spec.width, spec.height}, display{spec.full_x, spec.full_y, spec.full_width, spec.full_height};
        if (const auto whole = checkWindows(file, data, display); !whole) return tl::make_unexpected(whole.error());
    }
    return image;
}

/// Reads channels [begin, end) of every texel, interleaved and packed.
Result<void> readChannels(OpenedImage& image, const std::filesystem::path& file, int begin, int end, float* out) {
    for (int channel = begin; channel < end; ++channel)
        if (image.input->spec().channelformat(channel).basetype == OIIO::TypeDesc::UINT &&
            image.input->format_name() == std::string("openexr"))
            return failure(ErrorCode::FormatUnsupported,
                           fmt::format("{}, channel {}", file.string(), oneLine(image.channels[static_cast<std::size_t>(channel)])),
                           "found 32-bit integers (UINT), expected half or float");
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

/// Reads R, G and B as stored and ignores other channels.
Result<Image<glm::vec3>> loadRgb(const std::filesystem::path& file) {
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

Result<PlainImage> loadPlainImage(const std::filesystem::path& file) {
    Result<OpenedImage> image = openImage(file);
    if (!image) return tl::make_unexpected(image.error());
    PlainImage plain;
    plain.channelCount = image->channelCount;
    plain.texels = Image<glm::vec4>(image->width, image->height, glm::vec4(0, 0, 0, 1));
    const int alpha = image->input->spec().alpha_channel;
    const bool isGrey = plain.channelCount - (alpha >= 0 ? 1 : 0) == 1 && image->input->spec().channelnames.front() != "R";
    const int readCount = std::min(image->channelCount, 4);
    std::vector<float> values(plain.texels.texels().size() * static_cast<std::size_t>(readCount));
    if (const auto read = readChannels(*image, file, 0, readCount, values.data()); !read) return tl::make_unexpected(read.error());
    const float* next = values.data();
    for (glm::vec4& texel : plain.texels.texels()) {
        for (int channel = 0; channel < readCount; ++channel) texel[channel == alpha ? 3 : channel] = *next++;
        if (isGrey) texel.y = texel.z = texel.x;
    }
    return plain;
}

}  // namespace
}  // namespace lightcook::formats

extern "C" [[gnu::visibility("default")]] const lightcook::formats::ImageModule* lightcookImageModule() {
    namespace formats = lightcook::formats;
    static constexpr formats::ImageModule kModule = {LIGHTCOOK_VERSION, formats::loadRgb, formats::loadPlainImage};
    return &kModule;
}
