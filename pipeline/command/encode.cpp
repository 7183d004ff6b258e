#include "pipeline/command/encode.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "formats/color.h"
#include "formats/nearest.h"
#include "formats/plain_image.h"
#include "formats/vocabulary.h"
#include "pipeline/assets/textures.h"
#include "pipeline/command/command.h"
#include "pipeline/command/converter.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/texture_file.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Image;
using formats::PixelFormat;
using formats::Result;

/// Smaller and larger scales make no difference between the values of a half.
constexpr float kLeastMetricScale = 1e-6f, kLargestMetricScale = 65504;

std::vector<std::string> pixelFormatNames() {
    return formats::namesOf(formats::allPixelFormats());
}

Result<PixelFormat> formatFromName(const std::string& name) {
    if (const auto format = formats::pixelFormatFromName(name)) return *format;
    const std::vector<std::string> known = pixelFormatNames();
    return failure(ErrorCode::InvalidRequest, "--format",
                   fmt::format("found '{}', expected one of: {}{}", name, fmt::join(known, " "), formats::nearestHint(name, known)));
}

/// Returns the largest value that all channels of a format hold.
float largestOf(const formats::PixelFormatInfo& format) {
    if (!format.isFloat) return 1;
    if (format.format == PixelFormat::Rgb9e5) return 65408;
    return format.format == PixelFormat::R11g11b10f ? 64512 : 65504;
}

/// Values that checkTexels() looks for, and the end of its message.
struct TexelCheck {
    bool takesNegative = false;
    std::string otherwise = {};  ///< what else to do about a negative value
};

/// Refuses values that are not finite, and negative values. With `repair` sets infinity to the largest value of the format and others to
/// zero, and returns their number.
Result<std::int64_t> checkTexels(Image<glm::vec4>& texels, const std::filesystem::path& file, const formats::PixelFormatInfo& format,
                                 bool repair, const TexelCheck& check) {
    std::int64_t repaired = 0;
    const int channels = std::min(format.channelCount, 4);
    for (int y = 0; y < texels.height(); ++y)
        for (int x = 0; x < texels.width(); ++x)
            for (int c = 0; c < channels; ++c) {
                float& value = texels.at(x, y)[c];
                const bool isBroken = !std::isfinite(value), isNegative = value < 0 && !check.takesNegative;
                if (!isBroken && !isNegative) continue;
                if (!repair)
                    return failure(isBroken ? ErrorCode::ValueNotFinite : ErrorCode::ValueOutOfRange,
                                   formats::Subject(file).at(fmt::format("channel {}, texel ({}, {})", "RGBA"[c], x, y)),
                                   isBroken
                                       ? fmt::format("found {}, expected a finite value (--repair makes it {})", value,
                                                     value > 0 ? fmt::format("{}, the largest of the format", largestOf(format)) : "zero")
                                       : fmt::format("found {}, expected no negative value in {} (--repair makes it zero{})", value,
                                                     format.name, check.otherwise));
                value = isBroken && value > 0 ? largestOf(format) : 0.0f;
                ++repaired;
            }
    return repaired;
}

/// Converts an image to lin_rec709, the primaries that texture files state. Returns the space that it was in; empty: nothing was to do.
Result<std::string> convertColours(formats::PlainImage& image, const EncodeCommand& command) {
    if (command.source && formats::isPictureFile(command.input))
        return failure(ErrorCode::InvalidRequest, "--source",
                       fmt::format("found it with {}, a picture of integers, expected EXR or HDR", command.input.string()));
    if (image.channelCount - (image.hasAlpha ? 1 : 0) < 3) return std::string();
    const formats::ColorSpaces colors = colorsOf(command.source);
    LC_TRY(conversion, formats::linearConversion(colors, image.chromaticities));
    if (conversion->isIdentity) return std::string();
    for (glm::vec4& texel : image.texels.texels()) texel = glm::vec4(conversion->workingFromSource * glm::vec3(texel), texel.a);
    if (command.source && *command.source != formats::kStatedSource) return *command.source;
    const auto stated = formats::statedPrimaries(*image.chromaticities, *conversion);
    return stated && !stated->space.empty() ? stated->space : std::string(formats::kStatedSource);
}

/// Brings an image to the colours that are encoded, and refuses or repairs values that the format cannot hold. Returns what is to report.
Result<Json> prepareImage(formats::PlainImage& image, const EncodeCommand& command, const formats::PixelFormatInfo& format) {
    LC_TRY(repaired, checkTexels(image.texels, command.input, format, command.repair, {.takesNegative = true}));
    LC_TRY(space, convertColours(image, command));
    TexelCheck check{.takesNegative = format.isSigned};
    if (!space->empty())
        check.otherwise =
            fmt::format("; it is one after the conversion from {} to lin_rec709, which --source lin_rec709 leaves out", *space);
    std::int64_t outsideGamut = 0;
    if (!space->empty() && !command.source && !format.isSigned)
        for (glm::vec4& texel : image.texels.texels())
            for (int c = 0; c < 3; ++c)
                if (texel[c] < 0) {
                    texel[c] = 0;
                    ++outsideGamut;
                }
    LC_TRY(negative, checkTexels(image.texels, command.input, format, command.repair, check));
    std::int64_t transparent = 0;
    if (image.hasAlpha && format.channelCount < 4)
        transparent = std::ranges::count_if(image.texels.texels(), [](const glm::vec4& texel) { return texel.a != 1; });
    return Json{{"repaired", *repaired + *negative},
                {"clamped_negative", outsideGamut},
                {"transparent_texels", transparent},
                {"ignored_channels", image.ignored},
                {"converted_from", *space}};
}

/// Reads the weights of texels from the first channel of an image and scales the largest to 1.
Result<Image<float>> readSignificance(const std::filesystem::path& file, int width, int height) {
    LC_TRY(image, formats::readImage(file));
    const Image<glm::vec4>& texels = image->texels;
    if (texels.width() != width || texels.height() != height)
        return failure(ErrorCode::WrongShape, file,
                       fmt::format("found {} x {} texels, expected {} x {} as in the image to encode", texels.width(), texels.height(),
                                   width, height));
    float largest = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float weight = texels.at(x, y)[0];
            if (!std::isfinite(weight) || weight < 0)
                return failure(std::isfinite(weight) ? ErrorCode::ValueOutOfRange : ErrorCode::ValueNotFinite,
                               formats::Subject(file).at(fmt::format("texel ({}, {})", x, y)),
                               fmt::format("found a significance of {}, expected a finite one of at least 0", weight));
            largest = std::max(largest, weight);
        }
    Image<float> significance(width, height);
    // Only ratios count, and squares of huge weights would not be finite.
    for (std::size_t i = 0; i < significance.texels().size(); ++i)
        significance.texels()[i] = largest > 0 ? texels.texels()[i][0] / largest : 0.0f;
    return significance;
}

/// Returns true if the encoder of a format minimizes the error that --metric names.
bool takesMetric(const formats::PixelFormatInfo& format) {
    return format.format == PixelFormat::Bc6hUf16 || format.format == PixelFormat::Bc6hSf16 || format.format == PixelFormat::Rgb9e5;
}

bool isMadeOfBlocks(const formats::PixelFormatInfo& format) {
    return format.blockWidth > 1;
}

/// Returns true if the codes of one channel depend on the weights of the others. BC4 and BC5 code each channel of a block by itself.
bool codesChannelsTogether(const formats::PixelFormatInfo& format) {
    return format.format == PixelFormat::Rgb9e5 || (isMadeOfBlocks(format) && format.channelCount > 2);
}

/// A kind of option, which some formats take.
struct FormatOption {
    bool (*isTakenBy)(const formats::PixelFormatInfo& format);
    const char* reason;  ///< why the others do not, as a relative clause
};
constexpr FormatOption kMetricOption{takesMetric, "whose encoder minimizes an error of its own"};
constexpr FormatOption kWeightOption{codesChannelsTogether, "which codes each channel by itself"};
constexpr FormatOption kSignificanceOption{isMadeOfBlocks, "which codes each texel by itself"};

/// Refuses an option beside a format that it would not change.
Result<void> checkTaken(const char* option, bool isGiven, const FormatOption& kind, const formats::PixelFormatInfo& format) {
    if (!isGiven || kind.isTakenBy(format)) return {};
    std::vector<formats::PixelFormatInfo> taking;
    std::ranges::copy_if(formats::allPixelFormats(), std::back_inserter(taking), kind.isTakenBy);
    return failure(ErrorCode::InvalidRequest, option,
                   fmt::format("found it with --format {}, {}, expected --format {}", format.name, kind.reason,
                               formats::listOfNames(std::span<const formats::PixelFormatInfo>(taking))));
}

/// Refuses weights that would have no effect. The rows that --rdo bounds weigh both channels of BC5.
Result<void> checkWeightsTaken(const EncodeCommand& command, const formats::PixelFormatInfo& format) {
    if (command.rdo > 0 && format.channelCount > 1 && compress::supportsRdo(format.format)) return {};
    LC_CHECK(checkTaken("--weights", command.channelWeights.has_value(), kWeightOption, format));
    return checkTaken("--perceptual", command.perceptual, kWeightOption, format);
}

/// Refuses options that would have no effect. Efforts are taken beside every format, so that a script can give one to all.
Result<void> checkEffects(const EncodeCommand& command, const formats::PixelFormatInfo& format) {
    LC_CHECK(checkTaken("--metric", command.metric.has_value(), kMetricOption, format));
    LC_CHECK(checkTaken("--metric-scale", command.metricScale.has_value(), kMetricOption, format));
    if (command.perceptual && format.channelCount < 3)
        return failure(ErrorCode::InvalidRequest, "--perceptual",
                       fmt::format("found format {}, which holds no colour, expected one with red, green and blue", format.name));
    LC_CHECK(checkWeightsTaken(command, format));
    LC_CHECK(checkTaken("--significance", !command.significance.empty(), kSignificanceOption, format));
    if (command.metricScale && command.metric == compress::HdrMetric::Linear)
        return failure(ErrorCode::InvalidRequest, "--metric-scale",
                       "found it with --metric linear, which has no scale, expected --metric log or relative");
    return {};
}

Result<compress::EncodeOptions> optionsOf(const EncodeCommand& command, const formats::PixelFormatInfo& format) {
    LC_CHECK(checkEffects(command, format));
    compress::EncodeOptions options;
    options.effort = command.effort.value_or(options.effort);
    options.hdrMetric = command.metric.value_or(options.hdrMetric);
    options.hdrScale = command.metricScale.value_or(options.hdrScale);
    if (!(options.hdrScale >= kLeastMetricScale && options.hdrScale <= kLargestMetricScale))
        return failure(ErrorCode::InvalidRequest, "--metric-scale",
                       fmt::format("found {}, expected {} to {}", options.hdrScale, kLeastMetricScale, kLargestMetricScale));
    const std::array<float, 4> weights =
        command.perceptual ? compress::kLumaWeights : command.channelWeights.value_or(options.channelWeights);
    float largest = 0;
    bool areValid = true;
    for (std::size_t c = 0; c < 4; ++c) {
        const float weight = weights[c];
        areValid = areValid && std::isfinite(weight) && weight >= 0;
        if (static_cast<int>(c) < format.channelCount) largest = std::max(largest, weight);
    }
    if (!areValid || !(largest > 0))
        return failure(ErrorCode::InvalidRequest, "--weights",
                       fmt::format("found {}, expected four finite numbers of at least 0, one of the {} that {} has above 0",
                                   fmt::join(weights, ","), format.channelCount, format.name));
    for (std::size_t c = 0; c < 4; ++c) options.channelWeights[c] = static_cast<int>(c) < format.channelCount ? weights[c] / largest : 1.0f;
    if (!(command.rdo >= 0 && command.rdo <= kLargestRdo))
        return failure(ErrorCode::InvalidRequest, "--rdo", fmt::format("found {}, expected 0 to {}", command.rdo, kLargestRdo));
    if (command.rdo > 0 && !compress::supportsRdo(format.format))
        return failure(ErrorCode::InvalidRequest, "--rdo",
                       fmt::format("found format {}, expected one of BC1 to BC7: only their blocks repeat", format.name));
    options.rdo = static_cast<float>(command.rdo);
    return options;
}

/// Returns the shape of a texture of one level.
formats::TextureShape shapeOf(PixelFormat format, const Image<glm::vec4>& texels, int faceCount) {
    formats::TextureShape shape;
    shape.format = format;
    shape.width = texels.width();
    shape.faceCount = faceCount;
    shape.height = texels.height() / faceCount;
    return shape;
}

/// Refuses a format that the container of the output lacks.
Result<void> requireFormatOfContainer(const EncodeCommand& command, PixelFormat format) {
    if (containerOf(command.output) != formats::Container::Dds || formats::info(format).dxgiFormat != 0) return {};
    return failure(
        ErrorCode::InvalidRequest, "--format",
        fmt::format("found {} for {}, expected a format that DDS has, or a .ktx2 file", command.format, command.output.string()));
}

/// Encodes the faces of a texture, which lie below each other.
/// significance  without texels: all count alike
std::vector<std::vector<std::byte>> encodeStackedFaces(const formats::TextureShape& shape, const Image<glm::vec4>& texels,
                                                       const Image<float>& significance, const compress::EncodeOptions& options,
                                                       compress::EncodeReport& report) {
    std::vector<std::vector<std::byte>> images;
    for (int face = 0; face < shape.faceCount; ++face) {
        const int top = face * shape.height;
        formats::ImageView<const float> weights = significance.view();
        if (weights.texels != nullptr) weights = weights.rows(top, shape.height);
        images.push_back(encodeImage(shape.format, texels.view().rows(top, shape.height), weights, options, report));
    }
    return images;
}

}  // namespace

Result<Json> encodeTexture(const EncodeCommand& command, int threads) {
    LC_TRY(format, formatFromName(command.format));
    LC_CHECK(requireTextureFile(command.output));
    LC_CHECK(requireFormatOfContainer(command, *format));
    const formats::PixelFormatInfo& facts = formats::info(*format);
    LC_TRY(options, optionsOf(command, facts));
    LC_TRY(image, readPicture(command.input));
    if (*format == PixelFormat::Rgba8Srgb && formats::isPictureFile(command.input)) decodeSrgb(*image);
    Image<glm::vec4>& texels = image->texels;
    if (command.cube) LC_CHECK(formats::resampleEnvironment(*image, command.input));
    LC_TRY(prepared, prepareImage(*image, command, facts));
    if (command.cube && texels.height() != 6 * texels.width())
        return failure(ErrorCode::WrongShape, command.input,
                       fmt::format("found {} x {} texels, expected a vertical strip of six square faces", texels.width(), texels.height()));

    const formats::TextureShape shape = shapeOf(*format, texels, command.cube ? 6 : 1);
    TextureSettings settings;
    settings.container = containerOf(command.output);
    settings.zstd = command.zstd;
    Image<float> significance;
    if (!command.significance.empty()) {
        LC_TRY(read, readSignificance(command.significance, texels.width(), texels.height()));
        significance = std::move(*read);
    }
    compress::EncodeReport report;
    const auto start = std::chrono::steady_clock::now();
    const auto images = encodeStackedFaces(shape, texels, significance, *options, report);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    LC_TRY(folders, FoldersOfFile::make(command.output));
    LC_CHECK(writeTexture(command.output, shape, settings, {}, images));
    Json json = {{"width", shape.width},
                 {"height", shape.height},
                 {"mips", shape.mipCount},
                 {"layers", shape.layerCount},
                 {"faces", shape.faceCount},
                 {"format", std::string(facts.name)},
                 {"bytes", shape.gpuBytes()},
                 {"encode_seconds", seconds},
                 {"threads", threads},
                 {"clamped_high", report.clampedHigh},
                 {"clamped_negative", report.clampedNegative}};
    const std::int64_t outsideGamut = prepared->at("clamped_negative").get<std::int64_t>();
    json.update(*prepared);
    json["clamped_negative"] = report.clampedNegative + outsideGamut;
    return json;
}

namespace {

/// Says what of an image was not stored, or not stored as it is.
void reportOfImage(Terminal& terminal, const EncodeCommand& command, const Json& facts) {
    const std::string input = command.input.string();
    if (const auto count = facts.at("transparent_texels").get<std::int64_t>(); count > 0) {
        std::vector<formats::PixelFormatInfo> withAlpha;
        std::ranges::copy_if(formats::allPixelFormats(), std::back_inserter(withAlpha),
                             [](const auto& each) { return each.channelCount == 4; });
        terminal.warning(input,
                         fmt::format("found {} texels with an alpha that is not 1, which {} does not hold: the texture is opaque. "
                                     "Formats with alpha: {}",
                                     count, command.format, formats::listOfNames(std::span<const formats::PixelFormatInfo>(withAlpha))));
    }
    const auto ignored = facts.at("ignored_channels").get<std::vector<std::string>>();
    if (!ignored.empty())
        terminal.say(fmt::format("{}: not read: channel{} {}", input, ignored.size() == 1 ? "" : "s", fmt::join(ignored, ", ")));
    if (const auto space = facts.at("converted_from").get<std::string>(); !space.empty())
        terminal.say(fmt::format("{}: converted from {} to lin_rec709", input,
                                 space == formats::kStatedSource ? "the primaries that it states" : space));
}

}  // namespace

CommandFunction defineEncode(CLI::App& app) {
    struct Options : EncodeCommand {
        JsonOutput json;
        std::vector<float> weights;
        GivenKeys given;
        std::string metricName;
    };
    static const std::map<std::string, compress::HdrMetric> kMetrics = {
        {"log", compress::HdrMetric::Log}, {"linear", compress::HdrMetric::Linear}, {"relative", compress::HdrMetric::Relative}};
    const auto options = std::make_shared<Options>();
    addFileOption(app, "input", options->input, "EXR, HDR, or any image that OpenImageIO reads")->required();
    declareWritten(addFileOption(app, "output", options->output, "The .ktx2 or .dds file to write"), Written::File)->required();
    app.add_option("--format", options->format, "Pixel format of the texture")->required()->check(CLI::IsMember(pixelFormatNames()));
    addKeyOption(app, options->given, {"output.effort", "", {}, "Effort of the block encoders, 0 (fastest) to 9 (best); default: 5"});
    addKeyOption(app, options->given,
                 {"output.rdo",
                  "",
                  {},
                  "Rate-distortion optimization of BC blocks: the fraction by which the error of a row of blocks may grow so that the "
                  "compressed file shrinks, such as 2%"});
    app.add_option("--metric", options->metricName, "Error that the encoders of BC6H and RGB9E5 minimize")
        ->check(CLI::IsMember({"log", "linear", "relative"}))
        ->default_str("log");
    app.add_option("--metric-scale", options->metricScale, "Scale of the metrics log and relative, 1e-6 to 65504: about where dark begins")
        ->type_name("X")
        ->default_str("1");
    CLI::Option* weights =
        app.add_option("--weights", options->weights, "Weights of the channels' squared errors; only their ratios count");
    weights->delimiter(',')->expected(4)->type_name("R,G,B,A");
    app.add_flag("--perceptual", options->perceptual,
                 "Weigh channels as the eye does, for colours that are looked at: the luma weights of BT.709, and a third for alpha")
        ->excludes(weights);
    addFileOption(app, "--significance", options->significance,
                  "Image of the same size whose first channel is the weight of each texel: finite, at least 0; texels of 0 are free");
    app.add_flag("--cube", options->cube, "The input is a vertical strip of six cube faces");
    app.add_flag("--zstd", options->zstd, "Compress the texture inside KTX2 with Zstandard");
    app.add_flag(
        "--repair", options->repair,
        "Replace infinity by the largest value of the format, NaN and, in unsigned formats, negative values by zero, and count them");
    addKeyOption(app, options->given, sourceOption());
    options->json.add(app, "what was done");
    app.footer(R"(Metrics, for an input value x: log minimizes the squared error of log2(1 + x / scale), relative to the
value in the light and absolute in the dark; linear that of x, which keeps the energy but not the
shadows; relative that of dx / (x + scale), the slope taken at the input's value. Other float formats
round each channel to the nearest value, where the metric makes no difference, or have a logarithmic
error of their own (ASTC HDR). Formats of [0, 1] or [-1, 1] use the squared error.

Weights are taken by BC1, BC3, BC6H, BC7, ASTC and RGB9E5, and by BC5 with --rdo. Other formats code
their channels separately.

Significance is taken by all formats of blocks. In ASTC only zeros act: such texels take the value of
the nearest other texel of their block before it is encoded. A block without a significant texel is
encoded as if all counted.

--effort may stand beside every format: those without blocks round their texels, whatever it is.

--rdo 0.02 lets the root of the weighted squared error of any row of blocks grow by at most 2 %, in
the metric that was chosen; exact rows stay exact. The texture keeps its size on the GPU. The
compressed file shrinks by 5 to 25 %, for 2 to 3 microseconds a texel.

Pictures of integers (PNG, JPEG, TGA, BMP) keep their codes: as sRGB in rgba8-srgb, else as numbers from 0
to 1. EXR and HDR are linear light, which rgba8-srgb stores under its curve. Those that state primaries
(chromaticities of OpenEXR, PRIMARIES of Radiance) are converted to those of Rec.709, which texture
files state; --source lin_rec709 stores the values as they are. Of OpenEXR, channels R, G, B and A are
read, or Y as grey; others are named. With --cube, faces of an OpenEXR file with the attribute envmap
are turned from OpenEXR's directions to those of textures.

Negative values in unsigned formats are refused, also where the significance is 0, unless --repair is
given. Values above the format's largest are clamped to it, with a warning, and counted as
"clamped_high" in --json.

bc4-snorm and bc5-snorm hold one and two channels of [-1, 1]. Each channel of a block has 254 steps,
so 0 is exact. Values beyond either end are clamped and counted as "clamped_high" too. Byte -128
decodes to -1 like byte -127; the encoder writes only the latter.)");
    return [options](Session& session) {
        if (!options->weights.empty()) std::copy_n(options->weights.begin(), 4, options->channelWeights.emplace().begin());
        if (!options->metricName.empty()) options->metric = kMetrics.at(options->metricName);
        options->json.prepare(session);
        const auto settings = settingsOf(options->given);
        if (!settings) return session.finish(settings);
        options->effort = settings->output.effort;
        options->rdo = settings->output.rdo;
        if (const GivenKey* source = options->given.find("color.source")) options->source = source->value;
        const auto facts = encodeTexture(*options, session.threads);
        if (!facts) return options->json.finish(session, facts);
        constexpr std::array<std::pair<const char*, const char*>, 3> kChanges = {{
            {"clamped_high", "values beyond the range of the format, which became its end"},
            {"clamped_negative", "negative values, which became 0"},
            {"repaired", "values repaired"},
        }};
        for (const auto& [key, words] : kChanges)
            if (const auto count = facts->at(key).get<std::int64_t>(); count > 0)
                session.terminal.warning(options->input.string(), fmt::format("found {} {}", count, words));
        reportOfImage(session.terminal, *options, *facts);
        return options->json.finish(session, facts);
    };
}

}  // namespace lightcook::pipeline
