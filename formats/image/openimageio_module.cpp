// The module: everything that needs OpenImageIO, and nothing else. Linked into no program; image_module.cpp loads it at first use.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <mutex>

#include "formats/file/file_kind.h"
#include "formats/file/one_line.h"
#include "formats/image/image_claims.h"
#include "formats/image/image_module.h"
#include "formats/lower_extension.h"
#include "formats/memory.h"

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
    return failure(ErrorCode::FileUnreadable, file, fmt::format("found {}, expected a whole image file", quotedLine(library)));
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
    return failure(ErrorCode::FileUnreadable, file,
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
        return failure(ErrorCode::FileUnreadable, file, fmt::format("found {}, expected an image", *found));
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
    LC_CHECK(checkExtent(spec.width, spec.height, spec.nchannels, kFloatsThroughLibrary, file));
    // The densest are texels of one bit in Deflate, 8 in each of the 1032 bytes that a byte stands for.
    constexpr std::uint64_t kMostTexelsPerByte = 16384;
    const std::uint64_t texelCount = static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height);
    std::error_code code;
    if (const std::uintmax_t fileBytes = std::filesystem::file_size(file, code); !code)
        LC_CHECK(checkFileHolds(texelCount, fileBytes, kMostTexelsPerByte, file));
    if (spec.depth > 1 || spec.deep) {
        return failure(ErrorCode::FormatUnsupported, file, "found a volume or a deep image, expected a flat one");
    }
    if (const int orientation = spec.get_int_attribute("Orientation", 1); orientation != 1) {
        return failure(ErrorCode::FormatUnsupported, file,
                       fmt::format("found texels stored in orientation {}, expected row 0 on top and x to the right (1)", orientation));
    }
    return image;
}

/// Reads channels [begin, end) of every texel, interleaved and packed.
/// progress   see ImageModule
Result<void> readChannels(OpenedImage& image, const std::filesystem::path& file, int begin, int end, float* out, void (*progress)()) {
    const auto call = [](void* function, float /*share*/) {
        if (function != nullptr) (*static_cast<void (**)()>(function))();
        return false;  // go on
    };
    void* const function = progress != nullptr ? &progress : nullptr;
    if (image.input->read_image(0, 0, begin, end, OIIO::TypeDesc::FLOAT, out, OIIO::AutoStride, OIIO::AutoStride, OIIO::AutoStride, call,
                                function))
        return {};
    return unreadable(file, image.input->geterror());
}

Result<PlainImage> loadPlainImage(const std::filesystem::path& file, void (*progress)()) {
    Result<OpenedImage> image = openImage(file);
    if (!image) return tl::make_unexpected(image.error());
    PlainImage plain;
    plain.texels = Image<glm::vec4>(image->width, image->height, glm::vec4(0, 0, 0, 1));
    const int alpha = image->input->spec().alpha_channel, colourCount = image->channelCount - (alpha >= 0 ? 1 : 0);
    plain.channelCount = image->channelCount;
    plain.hasAlpha = alpha >= 0 && alpha < 4;
    if (image->channelCount == 4 && !plain.hasAlpha) {  // a fourth channel that is no alpha
        plain.ignored = {image->channels.back()};
        plain.channelCount = 3;
    }
    const bool isGrey = colourCount == 1 && image->channels.front() != "R";
    const int readCount = std::min(plain.channelCount, 4);
    std::vector<float> values(plain.texels.texels().size() * static_cast<std::size_t>(readCount));
    LC_CHECK(readChannels(*image, file, 0, readCount, values.data(), progress));
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
    static constexpr formats::ImageModule kModule = {LIGHTCOOK_VERSION, formats::loadPlainImage, formats::limitAvailableMemory};
    return &kModule;
}
