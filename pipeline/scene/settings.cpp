#include "pipeline/scene/settings.h"

#include <fmt/format.h>

#include <algorithm>

#include "formats/light_map_detail.h"
#include "formats/light_map_layout.h"
#include "formats/lmbake.h"
#include "formats/vocabulary.h"
#include "pipeline/scene/dominant_layout.h"
#include "pipeline/scene/rsrm_format.h"

namespace lightcook::pipeline {
namespace {

std::string costOf(const formats::DecodeLimits& decode, const formats::LightMapLayoutInfo& layout) {
    return fmt::format("{} ({} fetches, {} operations)", layout.name, decode.fetchesOf(layout), decode.operationsOf(layout));
}

/// Returns what is wrong with the filter of a layout, or an empty text.
std::string whyNotFilter(const formats::DecodeLimits& decode, const formats::LightMapLayoutInfo& layout) {
    if (!decode.filter || layout.mayHave(*decode.filter)) return "";
    const bool isDecoded = *decode.filter == formats::LightMapFilter::Decoded;
    return fmt::format("found filter {} for layout {}, expected {}: {}", isDecoded ? "decoded" : "hardware", layout.name,
                       isDecoded ? "hardware" : "decoded",
                       isDecoded ? "the engine filters its textures" : "its decode comes before the filter");
}

/// Returns what is wrong with limits that no layout of a list keeps, or an empty text.
std::string whyNoneKeeps(const formats::DecodeLimits& decode, const formats::LayoutList& layouts) {
    std::string costs;
    for (const formats::LightMapLayoutInfo& each : formats::allLightMapLayouts()) {
        if (!formats::isCandidate(layouts, each)) continue;
        if (decode.allow(each)) return "";
        if (!decode.filter || each.mayHave(*decode.filter)) costs += (costs.empty() ? "" : ", ") + costOf(decode, each);
    }
    if (costs.empty()) return "found a filter that none of the layouts has, expected the other one, or no filter";
    return fmt::format("found limits on the decode that no layout keeps, expected those of one of {}", costs);
}

/// Returns what is wrong with the limits on the decode and the list of layouts beside the layout that the settings select, or an empty
/// text.
std::string whyNotDecode(const OutputSettings& output) {
    const auto named = formats::lightMapLayoutFromName(layoutAsked(output));
    if (!named) return whyNoneKeeps(output.decode, output.layouts);
    if (!formats::mayTake(output.layouts, formats::info(*named)))
        return fmt::format("found layout {} that the list of layouts ({}) lacks, expected one of the list, or \"auto\"",
                           formats::info(*named).name, fmt::join(output.layouts, ", "));
    if (std::string why = whyNotFilter(output.decode, formats::info(*named)); !why.empty()) return why;
    if (output.decode.allow(formats::info(*named))) return "";
    return fmt::format("found layout {} over the limits on the decode, expected a cheaper one, or \"auto\" with a limit on the error",
                       costOf(output.decode, formats::info(*named)));
}

/// Returns what is wrong with the list of a light map beside the settings of the output, or an empty text.
std::string whyNotLayouts(const OutputSettings& output, const LightMapEntry& entry) {
    if (entry.layouts.empty()) return "";
    const std::string asked = layoutAsked(output);
    if (asked == kAutoLayout) return whyNoneKeeps(output.decode, entry.layouts);
    if (std::ranges::find(entry.layouts, asked) != entry.layouts.end()) return "";
    return fmt::format(
        "found a list of layouts for light map '{}' without layout {}, which the scene asks for, expected "
        "light_map_layout = \"auto\" in [output], or that layout in the list",
        entry.name, asked);
}

/// Returns what is wrong with packing the charts of a light map beside its other settings, or an empty text.
std::string whyNotPacked(const OutputSettings& output, const LightMapEntry& entry) {
    if (!isPacked(output, entry)) return "";
    const double maxVisible = chartsMaxVisible(output, entry);
    if (!entry.mesh)
        return fmt::format(
            "found charts of '{}' to pack without a mesh, expected mesh = \"FILE\", whose triangles say what a chart is, or charts = "
            "\"keep\"",
            entry.name);
    if (entry.groundTruth)
        return fmt::format(
            "found charts of '{}' to pack beside ground_truth, whose values lie at texels of the bake, expected charts = \"keep\" or no "
            "ground_truth",
            entry.name);
    if ((entry.limits[Limit::VisibleBound] || output.limits[Limit::VisibleBound]) && maxVisible > 0)
        return "found max_visible_bound beside charts with fewer texels, whose error has no bound, expected charts_max_visible = 0";
    if (output.isWholeLimited() && maxVisible > 0)
        return fmt::format("found {} beside charts with fewer texels, whose error it does not count, expected charts_max_visible = 0",
                           output.limits[Limit::WholeVisible] ? "max_whole_visible" : "max_whole_error");
    if (takesTangents(output, entry))
        return fmt::format(
            "found charts of '{}' to pack with a layout in tangent space, expected charts = \"keep\": its light is relative to the mesh as "
            "it is",
            entry.name);
    return "";
}

/// Returns what is wrong with the layouts of a light map that is turned into other axes, or an empty text.
std::string whyNotTurned(const OutputSettings& output, const LightMapEntry& entry) {
    if (entry.description.outputAxes.isIdentity()) return "";
    const std::string asked = layoutAsked(output);
    const formats::LayoutList one = {asked}, &layouts = asked == kAutoLayout ? layoutsFor(output, entry) : one;
    const auto isTurned = [](const std::string& name) {
        const auto layout = formats::lightMapLayoutFromName(name);
        return layout && formats::info(*layout).isForEngine && !formats::info(*layout).isInTangentSpace;
    };
    if (!layouts.empty() && std::ranges::all_of(layouts, isTurned)) return "";
    return "found light_map.output_axes beside a layout that lightcook.glsl decodes in the axes of the mesh, expected a layout with the "
           "directions of an engine's own shader: light_map_layout = \"bakery\", \"godot\", \"mono-sh\" or \"unreal-hq\"";
}

/// Returns the reason why the format of a reflection map is not possible for a target; empty if it is possible.
std::string whyNotFormat(const GradientEntry& entry, Target target) {
    const RsrmFormatInfo* const format = rsrmFormatFromName(entry.format);
    if (format == nullptr || format->isFor(target)) return "";
    std::string possible;
    for (const RsrmFormatInfo& each : allRsrmFormats())
        if (each.isFor(target)) possible += fmt::format("{}\"{}\"", possible.empty() ? "" : ", ", each.name);
    return fmt::format("found format \"{}\" with target \"{}\", expected target \"bc\" or a format of {}", entry.format,
                       formats::info(target).name, possible);
}

bool mayHaveDetail(const OutputSettings& output) {
    const auto named = formats::lightMapLayoutFromName(layoutAsked(output));
    return !named || formats::mayHaveDetail(formats::info(*named), output.decode, formats::info(output.target));
}

constexpr const char* kNoneIsPacked = "found charts_max_visible where no charts are packed, expected charts = \"pack\"";

}  // namespace

std::filesystem::path cookedFolder(const Scene& scene, const std::filesystem::path& given) {
    const std::filesystem::path folder = given.empty() ? std::filesystem::path(scene.name + ".cooked") : given;
    return scene.isOfTargets ? folder / formats::info(scene.output.target).name : folder;
}

std::string whyNothing(const Scene& scene) {
    // Materials alone bring the specular tables.
    const bool isEmpty = scene.lightMaps.empty() && scene.probes.empty() && scene.gradients.empty() && scene.materials.empty();
    return isEmpty ? "found nothing to cook, expected at least one table [[light_map]], [[probe]], [[gradient]] or [[material]]" : "";
}

std::vector<SettingsRule> rulesOf(const OutputSettings& output) {
    const bool isDds = output.container == formats::Container::Dds, isAuto = layoutAsked(output) == kAutoLayout;
    const std::string_view target = formats::info(output.target).name;
    const std::string decode = whyNotDecode(output);
    const char* const decodeKey = output.decode.filter         ? "filter"
                                  : output.decode.maxFetches   ? "max_fetches"
                                  : output.decode.maxDecodeOps ? "max_decode_ops"
                                                               : "layouts";
    return {
        {"effort", output.target == Target::Float,
         "found output.effort with target = \"float\", whose texels are not encoded, expected target = \"bc\" or \"astc\"", "target",
         Idle::Either},
        {"container", output.target == Target::Astc && isDds,
         "found container dds with target astc, expected container ktx2: DDS has no ASTC formats", "target"},
        {"zstd", output.zstd && isDds,
         "found zstd = true with container = \"dds\", expected container = \"ktx2\": DDS has no supercompression", "container"},
        {"rdo", output.rdo > 0 && output.target != Target::Bc,
         fmt::format("found output.rdo with target = \"{}\", expected target = \"bc\": only BC blocks repeat", target), "target"},
        {decodeKey, !decode.empty(), decode, "light_map_layout"},
        {"detail", output.detail == true && !isAuto && !output.limits[Limit::Visible],
         "found detail = true with a named layout and no max_visible, expected max_visible: tiles get detail until the map keeps it",
         "light_map_layout"},
        {"detail", output.detail == true && output.mips,
         "found detail = true with mips = true, expected one of them: levels above the first have no detail", "mips"},
        {"detail", output.detail == true && !isAuto && !mayHaveDetail(output),
         fmt::format(
             "found detail = true with layout {}, expected a layout that is decoded before the filter, takes fewer bits than {} and "
             "keeps within the limits on the decode with it",
             layoutAsked(output), formats::info(formats::kDetailLayout).name),
         "light_map_layout"},
        {"gltf", output.gltf && isDds, "found glTF with container dds, expected container ktx2", "container"},
        {"cost", !isAuto, "found output.cost where the layout is named, expected light_map_layout = \"auto\" with max_error or max_visible",
         "light_map_layout", Idle::InFile},
        {"cost", output.budgetBytes && !output.isErrorLimited(),
         "found output.cost where a budget chooses the layouts, expected max_error or max_visible as well", "budget", Idle::InFile},
    };
}

std::vector<SettingsRule> rulesOf(const formats::ColorSpaces& colors) {
    const auto empty = [](const char* key) {
        return fmt::format("found an empty text for color.{}, expected the name of a colour space", key);
    };
    return {{"source", colors.source.empty(), empty("source")},
            {"working", colors.working.empty(), empty("working")},
            {"working", colors.working == formats::kStatedSource,
             fmt::format("found \"{}\" for color.working, expected the name of a colour space: only a source can be stated by files",
                         formats::kStatedSource)}};
}

std::vector<SettingsRule> rulesOf(const Scene& scene, const LightMapEntry& entry) {
    const OutputSettings& output = scene.output;
    const formats::LightMapDescription& description = entry.description;
    const std::string layouts = whyNotLayouts(output, entry), packed = whyNotPacked(output, entry), turned = whyNotTurned(output, entry);
    const char* const charts = entry.charts.mode ? "charts" : "output.charts";
    const bool hasSurfaces = !description.mesh.empty(), isTurned = !description.outputAxes.isIdentity();
    const auto withoutMesh = [&](const char* key, const char* why) {
        return SettingsRule{key, !entry.mesh,
                            fmt::format("found light_map.{} without a mesh for '{}', expected mesh = \"FILE\": {}", key, entry.name, why)};
    };
    SettingsRule lmbake = withoutMesh("lmbake", "its nodes are in the lmbake");
    lmbake.isBroken = !hasSurfaces && !description.hasNoLmbake;
    return {
        {"surfaces", entry.mesh.has_value(), "found light_map.surfaces beside mesh, expected one of them: those of the mesh count", "mesh"},
        {"coverage", description.coverage == formats::CoverageSource::Mesh && !hasSurfaces,
         "found coverage \"mesh\" for a light map without a mesh, expected mesh = \"FILE\""},
        withoutMesh("max_seam", "seams are at its edges"),
        lmbake,
        {"lmbake", !description.lmbake.empty() && (!description.parts.empty() || !formats::mayTakeLmbake(description.bake)),
         fmt::format("found light_map.lmbake beside {}, expected a light map of Godot: {}",
                     description.parts.empty() ? "bake = \"" + description.bake + "\"" : "files",
                     fmt::join(formats::lmbakeBakeNames(), " or "))},
        withoutMesh("place", "it names its nodes"),
        {"place", !description.lmbake.empty(),
         fmt::format("found light_map.place beside {}, which places the nodes too, expected one of them: lmbake = \"{}\" leaves the file "
                     "out",
                     description.lmbake.filename().string(), formats::kNoLmbake)},
        {"dominant_fit", entry.dominantLayout == kDerivedDominant && !isDerivable(entry.dominantFit),
         fmt::format(
             "found dominant_fit \"{}\" beside dominant_layout = \"{}\", expected \"explained\": that is the light which the shader "
             "derives",
             entry.dominantFit, kDerivedDominant)},
        {"dominant_fit", entry.dominantLayout == kNoDominant,
         fmt::format("found light_map.dominant_fit beside dominant_layout = \"{}\", expected one of them: there is no dominant light",
                     kNoDominant)},
        {"layouts", !layouts.empty(), layouts, "output.light_map_layout"},
        {charts, !packed.empty(), packed},
        {"output_axes", !turned.empty(), turned, "output.light_map_layout"},
        {"output_axes", isTurned && output.gltf,
         "found light_map.output_axes with gltf = true, expected one of them: the glTF binds the light in the axes of its mesh",
         "output.gltf"},
        {"output_axes", isTurned && isPacked(output, entry),
         "found light_map.output_axes beside charts that are packed, expected charts = \"keep\"", charts},
        {"output_axes", isTurned && entry.groundTruth.has_value(),
         "found light_map.output_axes beside ground_truth, whose values are in the axes of the mesh, expected one of them", "ground_truth"},
        {"charts_max_visible", !isPacked(output, entry), kNoneIsPacked, charts, Idle::InFile},
    };
}

std::vector<SettingsRule> rulesOf(const OutputSettings& output, const GradientEntry& gradient) {
    const std::string format = whyNotFormat(gradient, output.target);
    const std::string_view rgba8 = info(RsrmFormat::Rgba8).name;
    return {{"encoding", gradient.axis && gradient.encoding != kGradientEncodings.front(),
             "found gradient.encoding beside an axis, expected it for painted gradients alone"},
            {"zones", !gradient.axis, "found gradient.zones without an axis, expected the axis to average around"},
            {"format", !format.empty(), format, "output.target"},
            {"dither", gradient.dither && !gradient.format.empty() && gradient.format != rgba8,
             fmt::format("found dither with format \"{}\", expected format \"{}\", whose codes alone are dithered", gradient.format, rgba8),
             "format"}};
}

std::vector<SettingsRule> rulesOf(const Scene& scene) {
    const bool isPhong = !formats::info(scene.lobe).distribution;
    const bool hasMesh = std::ranges::any_of(scene.lightMaps, [](const LightMapEntry& entry) { return entry.mesh.has_value(); });
    const bool isAnyPacked = std::ranges::any_of(scene.lightMaps, [&](const LightMapEntry& each) { return isPacked(scene.output, each); });
    const std::string_view lobe = formats::info(scene.lobe).name;
    return {{"output.max_seam", !hasMesh,
             "found a limit on seams where no light map has a mesh, expected mesh = \"FILE\" in a [[light_map]]: seams are at its edges"},
            {"output.gltf", scene.output.gltf && !hasMesh,
             "found output.gltf where no light map has a mesh, expected mesh = \"FILE\" in a [[light_map]]"},
            {"output.charts_max_visible", !isAnyPacked, kNoneIsPacked, "output.charts", Idle::InFile},
            {"lobe", isPhong && !(scene.lightMaps.empty() && scene.probes.empty()),
             fmt::format(
                 "found \"{0}\" for lobe, expected {1}: cubemaps and dominant lights have no Phong lobe (lightcook lut --lobe {0} makes "
                 "tables alone)",
                 lobe, formats::listOfNames(formats::sceneLobes()))},
            {"tables.normalization", isPhong && scene.tables.normalization != kNormalizationNames.front(),
             fmt::format("found \"{}\" with the lobe \"{}\", expected \"{}\", the only one of Phong lobes", scene.tables.normalization,
                         lobe, kNormalizationNames.front()),
             "lobe"}};
}

const formats::LayoutList& layoutsFor(const OutputSettings& output, const LightMapEntry& entry) {
    return entry.layouts.empty() ? output.layouts : entry.layouts;
}

bool takesTangents(const OutputSettings& output, const LightMapEntry& entry) {
    const std::string asked = layoutAsked(output);
    if (asked != kAutoLayout) return formats::isInTangentSpace(asked);
    return std::ranges::any_of(layoutsFor(output, entry), formats::isInTangentSpace);
}

double errorLimit(const OutputSettings& output) {
    return output.limits[Limit::Error].value_or(kDefaultMaxError);
}

bool isErrorLimited(const OutputSettings& output, const LightMapEntry& entry) {
    return output.isErrorLimited() || entry.limits.isAny(kAssetLimits);
}

Limits converterLimits(const OutputSettings& output, double byDefault, const Limits& ofAsset) {
    Limits limits = ofAsset;
    for (const LimitInfo& each : allLimits())
        if (each.isOfConverters() && !limits[each.held]) limits[each.held] = output.limits[each.id];
    if (!limits[Limit::Error]) limits[Limit::Error] = std::max(errorLimit(output), byDefault);
    return limits;
}

Limits limitsOf(const OutputSettings& output, const LightMapEntry& entry) {
    Limits limits = entry.limits;
    for (const Limit held : kAssetLimits)
        if (!limits[held] && (held != Limit::Seam || entry.mesh)) limits[held] = output.limits[held];
    limits[Limit::Visible] = visibleLimit(output, entry);
    return limits;
}

Limits layoutLimits(const OutputSettings& output, const LightMapEntry& entry) {
    Limits limits = limitsOf(output, entry);
    if (!limits[Limit::Error]) limits[Limit::Error] = kNoErrorLimit;
    return limits;
}

Limits wholeLimits(const OutputSettings& output) {
    return {{Limit::WholeVisible, output.limits[Limit::WholeVisible]}, {Limit::WholeError, output.limits[Limit::WholeError]}};
}

bool areViewsOpen(const TableSettings& tables, const OutputSettings& output) {
    return output.budgetBytes && !tables.viewCount;
}

int viewCountOf(const TableSettings& tables) {
    return tables.viewCount.value_or(kFineViewCount);
}

std::string layoutAsked(const OutputSettings& output) {
    return output.lightMapLayout.empty() ? kAutoLayout : output.lightMapLayout;
}

bool isByDefault(const OutputSettings& output, const LightMapEntry& entry) {
    return layoutAsked(output) == kAutoLayout && !output.isChosenByWhole() && !output.limits[Limit::Error] &&
           !askedVisibleLimit(output, entry) && !output.limits[Limit::VisibleBound] && !entry.limits[Limit::VisibleBound];
}

std::optional<double> askedVisibleLimit(const OutputSettings& output, const LightMapEntry& entry) {
    return entry.limits[Limit::Visible] ? entry.limits[Limit::Visible] : output.limits[Limit::Visible];
}

std::optional<double> visibleLimit(const OutputSettings& output, const LightMapEntry& entry) {
    return isByDefault(output, entry) ? std::optional(kDefaultMaxVisible) : askedVisibleLimit(output, entry);
}

bool hasMips(const OutputSettings& output, const LightMapEntry& entry) {
    return entry.mips.value_or(output.mips);
}

bool isPacked(const OutputSettings& output, const LightMapEntry& entry) {
    return entry.charts.mode.value_or(output.charts.mode.value_or(ChartMode::Keep)) != ChartMode::Keep;
}

double chartsMaxVisible(const OutputSettings& output, const LightMapEntry& entry) {
    return entry.charts.maxVisible ? *entry.charts.maxVisible : output.charts.maxVisible.value_or(0);
}

}  // namespace lightcook::pipeline
