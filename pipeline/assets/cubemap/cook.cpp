#include "pipeline/assets/cubemap/cubemap.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

#include "fit/cubemap.h"
#include "fit/pre_divide.h"
#include "fit/specular_tables.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/textures.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::Image;
using formats::PixelFormat;
using formats::Result;

Json toJson(const lighting::ShRgb& sh) {
    Json json = Json::array();
    for (const glm::vec3& c : sh) json.push_back({c.x, c.y, c.z});
    return json;
}

struct DividedLevels {
    std::vector<Image<glm::vec3>> levels;  ///< each a strip of six faces
    std::vector<std::int64_t> clamped;     ///< of each level: values of which the quotient is larger than any float
};

/// Every level prefiltered and divided. Rows are spread over the threads.
DividedLevels filterAndDivide(const fit::CubemapPrefilter& filter, const fit::PreDivide& divide, const ActionContext& context) {
    struct Task {
        int mip, face, size, firstRow;
        formats::ImageView<glm::vec3> rows;
    };
    constexpr int kRowsPerTask = 8;
    std::vector<Image<glm::vec3>> levels;
    std::vector<Task> tasks;
    for (const fit::MipKernel& mip : filter.mips()) levels.emplace_back(mip.size, 6 * mip.size);
    for (int mip = 0; mip < filter.mipCount(); ++mip) {
        Image<glm::vec3>& level = levels[static_cast<std::size_t>(mip)];
        const int size = level.width();
        for (int face = 0; face < 6; ++face)
            for (int row = 0; row < size; row += kRowsPerTask)
                tasks.push_back({mip, face, size, row, level.view().rows(face * size + row, std::min(kRowsPerTask, size - row))});
    }
    const bool finished = forEachPiece(tasks.size(), context, "filter " + context.action.asset, [&](std::size_t index) {
        const Task& task = tasks[index];
        filter.filterRows(task.mip, task.face, task.firstRow, task.rows.height, task.rows);
    });
    std::vector<std::atomic<std::int64_t>> clamped(levels.size());
    if (!finished) return {std::move(levels), {}};
    for (int mip = 0; mip < filter.mipCount(); ++mip) filter.keepMean(mip, levels[static_cast<std::size_t>(mip)].view());
    tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t index) {
        const Task& task = tasks[index];
        clamped[static_cast<std::size_t>(task.mip)] +=
            fit::preDivideRows(divide, task.mip, task.face, task.size, task.firstRow, task.rows, task.rows);
    });
    return {std::move(levels), {clamped.begin(), clamped.end()}};
}

/// Values that are light, and so much darker than the range that no half can hold them: their product with S is black.
std::int64_t lostBelow(const Image<glm::vec3>& level, float range) {
    constexpr float kHalfOfSmallestHalf = 0x1p-25f;
    std::int64_t lost = 0;
    for (const glm::vec3& texel : level.texels())
        for (int channel = 0; channel < 3; ++channel) lost += texel[channel] > 0 && texel[channel] / range <= kHalfOfSmallestHalf ? 1 : 0;
    return lost;
}

/// Where stored * S is not what was prefiltered since the stored numbers end: counts by level, of those that have any.
Json divisionNotes(const DividedLevels& divided, float range) {
    Json notes = {{"division_clamped", Json::object()}, {"division_lost", Json::object()}};
    for (std::size_t mip = 0; mip < divided.levels.size(); ++mip) {
        const std::string level = fmt::format("level {}", mip);
        if (divided.clamped[mip] > 0) notes["division_clamped"][level] = divided.clamped[mip];
        if (const std::int64_t lost = lostBelow(divided.levels[mip], range); lost > 0) notes["division_lost"][level] = lost;
    }
    return notes;
}

float brightest(const std::vector<Image<glm::vec3>>& levels) {
    float largest = 0;
    for (const auto& level : levels)
        for (const glm::vec3& texel : level.texels()) largest = std::max({largest, texel.x, texel.y, texel.z});
    return largest;
}

Json cubemapConstants(const fit::CubemapPrefilter& filter, const fit::PreDivide& divide, float range) {
    Json mips = Json::array();
    for (const fit::MipKernel& mip : filter.mips())
        mips.push_back({{"perceptual_roughness", mip.perceptualRoughness}, {"m", mip.m}, {"bands", mip.bands}});
    return {{"range", range},
            {"kernel", "beckmann"},
            {"mips", mips},
            {"windowed_sh", toJson(divide.windowedSh)},
            {"window", divide.window},
            {"window_lambda", divide.windowLambda},
            {"epsilon", divide.epsilon}};
}

std::vector<float> floats(const glm::vec4& v) {
    return {v.x, v.y, v.z, v.w};
}

Json axisJson(const fit::TableAxis& axis, const fit::AxisMapping& mapping) {
    return {{"of", mapping.name},
            {"factors", mapping.factors},
            {"count", axis.count},
            {"minimum", axis.minimum},
            {"maximum", axis.maximum},
            {"scale", axis.coordinateScale},
            {"offset", axis.coordinateOffset}};
}

/// Axes that were asked for, or those that lose least.
void chooseAxes(const Json& parameters, fit::SpecularTableOptions& options) {
    const std::string view = parameters.at("view_axis"), roughness = parameters.at("roughness_axis");
    if (view == "auto" || roughness == "auto") {
        const auto f0 = parameters.at("f0").get<std::array<double, 2>>();
        fit::chooseMappings(options, f0[0], f0[1]);
    }
    if (view != "auto") options.view = fit::viewMapping(view);
    if (roughness != "auto") options.roughness = fit::roughnessMapping(roughness);
}

}  // namespace

std::optional<lighting::SpecularLobe> lobeOf(const std::string& name) {
    const auto place = std::find(kLobeNames.begin(), kLobeNames.end(), name);
    if (place == kLobeNames.end()) return std::nullopt;
    constexpr std::array kLobes = {lighting::SpecularLobe::Beckmann, lighting::SpecularLobe::Ggx, lighting::SpecularLobe::Phong,
                                   lighting::SpecularLobe::PhongPower};
    return kLobes.at(static_cast<std::size_t>(place - kLobeNames.begin()));
}

Json toJson(const formats::ColorSpaces& colors) {
    return {{"source", colors.source}, {"working", colors.working}};
}

formats::EnvironmentOptions environmentOptions(const Json& json, const Action& action) {
    const Json& colors = json.at("colors");
    return {colorSpacesOf(colors.at("source").get<std::string>(), colors.at("working").get<std::string>(), action),
            json.at("repair").get<bool>()};
}

Result<ActionOutcome> cookCubemap(const ActionContext& context) {
    const Json& parameters = context.action.parameters;
    const TextureSettings settings = TextureSettings::fromJson(parameters.at("textures"));
    const auto& source = context.action.inputs.at("source");
    const auto loaded = formats::loadEnvironment(source, environmentOptions(parameters, context.action));
    if (!loaded) return tl::make_unexpected(loaded.error());
    lighting::ShRgb sh = fit::projectEnvironment(loaded->environment);
    if (const auto shFile = context.action.inputs.find("sh"); shFile != context.action.inputs.end()) {
        const auto stored = formats::loadProbeSh(shFile->second, parameters.at("probe_file").get<std::string>());
        if (!stored) return tl::make_unexpected(stored.error());
        sh = *stored;
    }
    fit::CubemapOptions options;
    options.size = parameters.at("size").get<int>();
    const auto filter = fit::CubemapPrefilter::create(loaded->environment, options);
    if (!filter) return tl::make_unexpected(filter.error());
    std::vector<lighting::ShBands> bands;
    for (const fit::MipKernel& mip : filter->mips()) bands.push_back(mip.bands);
    const fit::PreDivide divide = fit::makePreDivide(sh, bands, {});
    const DividedLevels divided = filterAndDivide(*filter, divide, context);
    const std::vector<Image<glm::vec3>>& levels = divided.levels;
    if (context.state.interrupted) return interrupted(context);

    const float range = hdrRange(brightest(levels));
    formats::TextureShape shape;
    shape.format = hdrFormat(parameters.at("target").get<std::string>());
    shape.width = shape.height = options.size;
    shape.mipCount = filter->mipCount();
    shape.faceCount = 6;
    compress::EncodeReport report;
    WholeTexture texture{"cubemap", context.action.asset, shape, {}, {"trilinear", "clamp"}};
    for (const Image<glm::vec3>& level : levels)
        for (auto& face : encodeFaces(shape.format, level.view(), range, settings.encodeOptions(), report))
            texture.images.push_back(std::move(face));
    const Json constants = cubemapConstants(*filter, divide, range);
    ActionOutcome outcome;
    const auto packed = packTexture(context, texture, settings, {{"layout", "pre-divided-cubemap"}, {"constants", constants}}, outcome);
    if (!packed) return tl::make_unexpected(packed.error());
    outcome.result["asset"] = {{"name", context.action.asset},
                               {"kind", "cubemap"},
                               {"layout", "pre-divided"},
                               {"width", options.size},
                               {"height", options.size},
                               {"quantity", "prefiltered radiance over its own area specular"},
                               {"units", "radiometric"},
                               {"phase", "none"},
                               {"frame", "world"},
                               {"constants", constants},
                               {"textures", Json::array({*packed})},
                               {"source", {{"colors", parameters.at("colors")}, {"repair", parameters.at("repair")}}}};
    outcome.result["bytes_in"] = std::filesystem::file_size(source);
    outcome.result["notes"] = {
        {"repaired_texels", loaded->repairedTexels}, {"clamped_high", report.clampedHigh}, {"window_lambda", divide.windowLambda}};
    outcome.result["notes"].update(divisionNotes(divided, range));
    return outcome;
}

Result<ActionOutcome> cookTables(const ActionContext& context) {
    const Json& parameters = context.action.parameters;
    const TextureSettings settings = TextureSettings::fromJson(parameters.at("textures"));
    fit::SpecularTableOptions options;
    const std::string lobe = parameters.at("lobe"), normalization = parameters.at("normalization");
    options.lobe = lobeOf(lobe).value();
    options.normalization =
        normalization == "halo3" ? lighting::CookTorranceNormalization::Halo3 : lighting::CookTorranceNormalization::Energy;
    options.viewCount = parameters.at("view_count").get<int>();
    options.roughnessCount = parameters.at("roughness_count").get<int>();
    options.minimumM = parameters.at("minimum_m").get<double>();
    options.maximumM = parameters.at("maximum_m").get<double>();
    if (auto usable = fit::checkSpecularTableOptions(options); !usable) return tl::make_unexpected(usable.error());
    chooseAxes(parameters, options);
    std::vector<std::vector<lighting::AreaSpecularKernel>> rows(static_cast<std::size_t>(options.roughnessCount));
    tbb::parallel_for(0, options.roughnessCount,
                      [&](int row) { rows[static_cast<std::size_t>(row)] = fit::integrateSpecularTableRow(options, row); });
    const fit::SpecularTables tables = fit::assembleSpecularTables(options, rows);

    formats::TextureShape shape;
    shape.format = PixelFormat::Rgba16Unorm;
    shape.width = options.viewCount;
    shape.height = options.roughnessCount;
    ActionOutcome outcome;
    Json textures = Json::array(),
         constants = {{"view", axisJson(tables.view, options.view)}, {"roughness", axisJson(tables.roughness, options.roughness)}};
    const std::pair<const char*, const fit::SpecularTexture*> parts[] = {
        {"c0236", &tables.c0236}, {"d0236", &tables.d0236}, {"cd78", &tables.cd78}};
    for (const auto& [role, texture] : parts) {
        constants[std::string(role) + "_scale"] = floats(texture->scale);
        constants[std::string(role) + "_bias"] = floats(texture->bias);
    }
    const Json facts = {
        {"layout", "cook-torrance-tables"}, {"distribution", lobe}, {"normalization", normalization}, {"constants", constants}};
    for (const auto& [role, texture] : parts) {
        const WholeTexture whole{role, context.action.asset + "_" + role, shape, {bytesOf(texture->stored)}, {}};
        const auto packed = packTexture(context, whole, settings, facts, outcome);
        if (!packed) return tl::make_unexpected(packed.error());
        textures.push_back(*packed);
    }
    outcome.result["asset"] = {{"name", context.action.asset},
                               {"kind", "lut"},
                               {"layout", "cook-torrance-cd"},
                               {"width", shape.width},
                               {"height", shape.height},
                               {"quantity", "SH coefficients of the area-specular kernel"},
                               {"distribution", lobe},
                               {"normalization", normalization},
                               {"phase", "none"},
                               {"frame", "z the normal, the view in the x-z plane"},
                               {"constants", constants},
                               {"textures", textures}};
    outcome.result["bytes_in"] = 0;
    return outcome;
}

}  // namespace lightcook::pipeline
