#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fit/azimuthal_average.h"
#include "formats/vocabulary.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/assets/rsrm/comparison.h"
#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Image;
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
    formats::Subject place;  ///< that messages name
};

/// Reads a painted gradient, or averages an environment around an axis.
Result<Gradient> loadGradient(const std::filesystem::path& file, const AssetSource& source, const Action& action) {
    const formats::EnvironmentOptions options = environmentOptions(source, action);
    if (!source.axis) {
        LC_TRY(painted, formats::loadPaintedGradient(file, options, encodingOf(source.encoding.value_or("auto"))));
        return Gradient{std::move(painted->zones), painted->repairedTexels, file};
    }
    LC_TRY(loaded, formats::loadEnvironment(file, options));
    const int zones = source.zones.value_or(0);
    LC_CHECK(fit::checkAzimuthalAverage(*source.axis, zones));
    return Gradient{fit::averageAroundAxis(loaded->environment, *source.axis, zones).gradient, loaded->repairedTexels,
                    formats::Subject(file).at("averaged")};
}

/// Returns the scale below which errors of a floating-point format count as absolute ones: a tenth of the log-average light.
float darkScale(const fit::Rsrm& map) {
    double sum = 0, logSum = 0;
    const auto lightOf = [](const glm::dvec3& value) { return (value.x + value.y + value.z) / 3; };
    const auto& values = map.values.texels();
    for (const glm::dvec3& value : values) sum += lightOf(value);
    if (!(sum > 0)) return 1;
    const double count = static_cast<double>(values.size()), least = 1e-4 * sum / count;
    for (const glm::dvec3& value : values) logSum += std::log(std::max(lightOf(value), least));
    return static_cast<float>(0.1 * std::exp(logSum / count));
}

std::vector<std::byte> encodeMap(const fit::Rsrm& map, const RsrmFormatInfo& format, const TextureSettings& settings) {
    const int width = map.codes.width(), height = map.codes.height();
    if (format.id == RsrmFormat::Rgba8) {
        Image<glm::u8vec4> texels(width, height);
        for (std::size_t i = 0; i < texels.texels().size(); ++i) texels.texels()[i] = glm::u8vec4(map.codes.texels()[i], 255);
        return bytesOf(texels);
    }
    Image<glm::vec4> texels = toRgba((format.isFloat ? fit::floatValues(map) : fit::scaledValues(map)).view());
    // One channel: the largest. The others are multiples of it, or black.
    if (format.id == RsrmFormat::Bc4)
        for (glm::vec4& texel : texels.texels()) texel = glm::vec4(std::max({texel.x, texel.y, texel.z}), 0, 0, 1);
    compress::EncodeOptions options = settings.encodeOptions();
    if (format.isFloat) options.hdrScale = std::max(darkScale(map) / fit::floatRange(map), 1e-6f);
    // Any other metric may cut the largest channel of a saturated colour in half for the sake of a small one.
    if (format.codes == verify::RsrmCodes::SharedExponent) options.hdrMetric = compress::HdrMetric::Linear;
    compress::EncodeReport report;
    return encodeImage(format.pixels, texels.view(), {}, options, report);
}

/// A map in a format.
struct EncodedMap {
    const RsrmFormatInfo* format = nullptr;
    int width = 0;
    RsrmConstants constants;
    std::vector<std::byte> bytes;
};

/// Encodes a gradient in formats and widths, and measures each as the verification will.
class FormatSearch {
public:
    FormatSearch(const RsrmParameters& parameters, const Gradient& gradient, const fit::RsrmOptions& options,
                 const glm::vec3& luminanceWeights, const ActionContext& context)
        : parameters_(parameters), gradient_(gradient), options_(options), luminanceWeights_(luminanceWeights), context_(context) {}

    /// Returns the map in the first format that keeps the limit, at the fewest columns. The most precise format, which is the last one,
    /// says first whether a number of columns can keep it: between texels of a sun that is one texel wide, no format does at 256. If
    /// nothing keeps the limit, returns the first map that the verification passes, or else the first one.
    Result<EncodedMap> find() {
        LC_TRY(formats, usableFormats());
        isNamed_ = parameters_.formats.size() == 1;
        for (int width = parameters_.width; width <= kMostColumns; width *= 2) {
            options_.width = width;
            const fit::Rsrm map = fit::makeRsrm(gradient_.zones, options_);
            if (width == parameters_.width && formats->size() > 1) {
                auto first = attempt(*formats->front(), map);
                if (!first || keeps_) return first;
            }
            LC_TRY(last, attempt(*formats->back(), map));
            if (!keeps_) continue;
            for (const RsrmFormatInfo* format : *formats) {
                if (format == formats->back()) break;
                auto each = attempt(*format, map);
                if (!each || keeps_) return each;
            }
            return last;
        }
        return std::move(*fallback_);
    }
    /// Returns the errors by format, where more than one was tried.
    const Json& tried() const { return tried_; }

private:
    static constexpr int kMostColumns = 2048;

    /// Leaves out bc4 where there is a choice and the gradient has more than one colour.
    Result<std::vector<const RsrmFormatInfo*>> usableFormats() const {
        std::vector<const RsrmFormatInfo*> usable;
        for (const std::string& name : parameters_.formats) {
            const RsrmFormatInfo* const format = rsrmFormatFromName(name);
            if (format == nullptr)
                return failure(ErrorCode::InvalidRequest, context_.action.asset,
                               fmt::format("found format \"{}\", expected {}", name, formats::listOfNames(allRsrmFormats())));
            const auto zone = format->id == RsrmFormat::Bc4 ? fit::firstZoneOfAnotherHue(gradient_.zones) : std::nullopt;
            if (zone && parameters_.formats.size() == 1)
                return failure(ErrorCode::ValueOutOfRange, gradient_.place.at(fmt::format("zone {}", *zone)),
                               "found a colour of its own, expected one colour for format \"bc4\" (or format \"bc7\")");
            if (!zone) usable.push_back(format);
        }
        if (usable.empty())
            return failure(ErrorCode::InvalidRequest, context_.action.asset, "found no format to try, expected one at least");
        return usable;
    }

    /// Encodes a map, and sets keeps_. A format that was named is held to what the verification asks for, and no more.
    Result<EncodedMap> attempt(const RsrmFormatInfo& format, const fit::Rsrm& map) {
        EncodedMap encoded;
        encoded.format = &format;
        encoded.width = options_.width;
        encoded.constants.color = format.isFloat ? glm::vec3(fit::floatRange(map)) : map.color;
        encoded.constants.exponents = map.exponents;
        if (format.id == RsrmFormat::Bc4) encoded.constants.channels = 1;
        encoded.bytes = encodeMap(map, format, parameters_.textures);
        const verify::CookedRsrm decoded = decodedRsrm(format, options_.dither, encoded.constants, encoded.bytes, encoded.width);
        const auto comparison = compareRsrm(decoded, {gradient_.zones, {}}, luminanceWeights_, context_,
                                            fmt::format("try {} on {}", format.name, context_.action.asset));
        if (!comparison) return interrupted(context_);
        const RsrmFormatErrors errors = formatErrors(*comparison);
        const bool passes = errors.passes(parameters_.limit);
        keeps_ = isNamed_ ? passes : errors.keeps(parameters_.limit);
        if (!fallback_ || (passes && !isFallbackSound_)) fallback_ = encoded;
        isFallbackSound_ = isFallbackSound_ || passes;
        const std::string columns = encoded.width == parameters_.width ? "" : fmt::format(", {} columns", encoded.width);
        tried_[std::string(format.name) + columns] = {{"rel_rms", errors.relRms}, {"p99", errors.p99}};
        return encoded;
    }

    const RsrmParameters& parameters_;
    const Gradient& gradient_;
    fit::RsrmOptions options_;
    glm::vec3 luminanceWeights_;
    const ActionContext& context_;
    Json tried_ = Json::object();
    bool isNamed_ = false, keeps_ = false;
    std::optional<EncodedMap> fallback_;  ///< the first map that the verification passes, else the first of all
    bool isFallbackSound_ = false;
};

/// Returns the options of the map, if the gradient can be cooked with them.
Result<fit::RsrmOptions> optionsOf(const RsrmParameters& parameters, const Gradient& gradient) {
    fit::RsrmOptions options;
    options.width = parameters.width;
    options.exponents = parameters.exponents;
    options.dither = parameters.dither;
    if (const auto usable = fit::checkRsrm(gradient.zones, options); !usable)
        return failure(usable.error().code, gradient.place.at(usable.error().subject), usable.error().detail);
    return options;
}

}  // namespace

formats::GradientEncoding encodingOf(const std::string& name) {
    if (name == "linear") return formats::GradientEncoding::Linear;
    return name == "srgb" ? formats::GradientEncoding::Srgb : formats::GradientEncoding::Auto;
}

Result<ActionOutcome> cookRsrm(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<RsrmParameters>(context));
    const auto& file = context.action.inputs.at("source");
    const AssetSource source = sourceOf(*parameters);
    LC_TRY(gradient, loadGradient(file, source, context.action));
    LC_TRY(options, optionsOf(*parameters, *gradient));

    LC_TRY(colors, formats::linearConversion(environmentOptions(source, context.action).colors));
    FormatSearch search(*parameters, *gradient, *options, colors->luminanceWeights, context);
    LC_TRY(map, search.find());

    formats::TextureShape shape;
    shape.format = map->format->pixels;
    shape.width = map->width;
    shape.height = static_cast<int>(options->exponents.size());
    const Json constants = toJson(map->constants);
    const std::string& name = context.action.asset;
    const std::string layout = "rsrm";
    AssetTextures textures(context, parameters->textures, {AssetKind::Rsrm, layout});
    LC_CHECK(textures.write({"rsrm", name, shape, constants}, {map->bytes}));

    CookResult result{makeCookedAsset(name, AssetKind::Rsrm, layout, shape.width, shape.height), std::filesystem::file_size(file),
                      Json{{note_keys::kZones, gradient->zones.size()}}};
    if (search.tried().size() > 1) (*result.notes)[note_keys::kFormatsTried] = search.tried();
    (*result.notes)[note_keys::kRepairedTexels] = gradient->repairedTexels;
    result.asset.dither = options->dither;
    result.asset.constants = constants;
    result.asset.axis = parameters->north;
    result.asset.source = source;
    return textures.finish(std::move(result));
}

}  // namespace lightcook::pipeline
