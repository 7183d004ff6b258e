#include <fmt/format.h>

#include <algorithm>

#include "fit/azimuthal_average.h"
#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/assets/source_colors.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Image;
using formats::PixelFormat;
using formats::Result;

/// Returns how the source is read, for the manifest and the verification.
AssetSource sourceOf(const RsrmParameters& parameters) {
    AssetSource source;
    source.colors = parameters.colors;
    source.repair = parameters.repair;
    source.encoding = parameters.encoding;
    source.axis = parameters.axis;
    source.zones = parameters.zones;
    return source;
}

struct Gradient {
    std::vector<glm::vec3> zones;
    std::int64_t repairedTexels = 0;
    std::string place;  ///< that messages name
};

/// Reads a painted gradient, or averages an environment around an axis.
Result<Gradient> loadGradient(const std::filesystem::path& file, const AssetSource& source, const Action& action) {
    const formats::EnvironmentOptions options = environmentOptions(source, action);
    if (!source.axis) {
        auto painted = formats::loadGradient(file, options, encodingOf(source.encoding.value_or("auto")));
        if (!painted) return tl::make_unexpected(painted.error());
        return Gradient{std::move(*painted), 0, file.string()};
    }
    const auto loaded = formats::loadEnvironment(file, options);
    if (!loaded) return tl::make_unexpected(loaded.error());
    const int zones = source.zones.value_or(0);
    if (auto usable = fit::checkAzimuthalAverage(*source.axis, zones); !usable) return tl::make_unexpected(usable.error());
    return Gradient{fit::averageAroundAxis(loaded->environment, *source.axis, zones).gradient, loaded->repairedTexels,
                    file.string() + ", averaged"};
}

std::vector<std::byte> encodeMap(const fit::Rsrm& map, PixelFormat format, const TextureSettings& settings) {
    const int width = map.codes.width(), height = map.codes.height();
    if (format == PixelFormat::Rgba8Unorm) {
        Image<glm::u8vec4> texels(width, height);
        for (std::size_t i = 0; i < texels.texels().size(); ++i) texels.texels()[i] = glm::u8vec4(map.codes.texels()[i], 255);
        return bytesOf(texels);
    }
    Image<glm::vec4> texels = toRgba(fit::scaledValues(map).view());
    // One channel: the largest. The others are multiples of it, or black.
    if (format == PixelFormat::Bc4)
        for (glm::vec4& texel : texels.texels()) texel = glm::vec4(std::max({texel.x, texel.y, texel.z}), 0, 0, 1);
    compress::EncodeReport report;
    return encodeImage(format, texels.view(), {}, settings.encodeOptions(), report);
}

PixelFormat formatOf(const std::string& name) {
    if (name == "bc7") return PixelFormat::Bc7;
    return name == "bc4" ? PixelFormat::Bc4 : PixelFormat::Rgba8Unorm;
}

/// Returns the options of the map, if the gradient can be cooked with them.
Result<fit::RsrmOptions> optionsOf(const RsrmParameters& parameters, const Gradient& gradient) {
    fit::RsrmOptions options;
    options.width = parameters.width;
    options.exponents = parameters.exponents;
    options.dither = parameters.dither;
    if (auto usable = fit::checkRsrm(gradient.zones, options); !usable) {
        formats::Error error = usable.error();
        error.subject = gradient.place + ", " + error.subject;
        return tl::make_unexpected(error);
    }
    if (formatOf(parameters.format) == PixelFormat::Bc4)
        if (const auto zone = fit::firstZoneOfAnotherHue(gradient.zones))
            return failure(ErrorCode::ValueOutOfRange, fmt::format("{}, zone {}", gradient.place, *zone),
                           "found a colour of its own, expected one colour for format \"bc4\" (or format \"bc7\")");
    return options;
}

}  // namespace

formats::GradientEncoding encodingOf(const std::string& name) {
    if (name == "linear") return formats::GradientEncoding::Linear;
    return name == "srgb" ? formats::GradientEncoding::Srgb : formats::GradientEncoding::Auto;
}

Result<ActionOutcome> cookRsrm(const ActionContext& context) {
    const auto parameters = parametersOf<RsrmParameters>(context);
    if (!parameters) return tl::make_unexpected(parameters.error());
    const auto& file = context.action.inputs.at("source");
    const AssetSource source = sourceOf(*parameters);
    const auto gradient = loadGradient(file, source, context.action);
    if (!gradient) return tl::make_unexpected(gradient.error());
    const auto options = optionsOf(*parameters, *gradient);
    if (!options) return tl::make_unexpected(options.error());
    const fit::Rsrm map = fit::makeRsrm(gradient->zones, *options);

    formats::TextureShape shape;
    shape.format = formatOf(parameters->format);
    shape.width = options->width;
    shape.height = static_cast<int>(options->exponents.size());
    const bool isGrey = shape.format == PixelFormat::Bc4;
    const Json constants = toJson(RsrmConstants{map.color, options->exponents, isGrey ? std::optional(1) : std::nullopt});
    const std::string& name = context.action.asset;
    AssetTextures textures(context, parameters->textures);
    if (auto written = textures.write({"rsrm", name, shape, {{"layout", "rsrm"}, {"constants", constants}}},
                                      {encodeMap(map, shape.format, parameters->textures)});
        !written)
        return tl::make_unexpected(written.error());

    CookResult result{makeCookedAsset(name, AssetKind::Rsrm, "rsrm", shape.width, shape.height), std::filesystem::file_size(file),
                      Json{{"zones", gradient->zones.size()}}};
    if (source.axis) (*result.notes)["repaired_texels"] = gradient->repairedTexels;
    result.asset.dither = options->dither;
    result.asset.constants = constants;
    result.asset.source = source;
    return textures.finish(std::move(result));
}

}  // namespace lightcook::pipeline
