#include "pipeline/cook/chart_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "pipeline/cook/split_maps.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

/// Returns what is wrong with packing the charts of a light map beside its other settings, or an empty text.
std::string whyNotPacked(const OutputSettings& output, const LightMapEntry& entry) {
    const double maxVisible = chartsMaxVisible(output, entry);
    if (!entry.mesh)
        return "found charts to pack without a mesh, expected mesh = \"FILE\", whose triangles say what a chart is, or charts = \"keep\"";
    if (entry.groundTruth)
        return "found charts to pack beside ground_truth, whose values lie at texels of the bake, expected charts = \"keep\" or no "
               "ground_truth";
    if ((entry.limits[Limit::VisibleBound] || output.limits[Limit::VisibleBound]) && maxVisible > 0)
        return "found max_visible_bound beside charts with fewer texels, whose error has no bound, expected charts_max_visible = 0";
    if (output.isWholeLimited() && maxVisible > 0)
        return fmt::format("found {} beside charts with fewer texels, whose error it does not count, expected charts_max_visible = 0",
                           output.limits[Limit::WholeVisible] ? "max_whole_visible" : "max_whole_error");
    if (takesTangents(output, entry))
        return "found charts to pack with a layout in tangent space, expected charts = \"keep\": its light is relative to the mesh as it "
               "is";
    return "";
}

/// Returns the kind of the asset that a scene lists by a name. Empty: it lists none.
std::string_view kindOfAsset(const Scene& scene, const std::string& name) {
    const auto has = [&](const auto& entries, auto nameOf) { return std::ranges::find(entries, name, nameOf) != entries.end(); };
    if (has(scene.lightMaps, &LightMapEntry::name)) return "light map";
    if (has(scene.probes, &ProbeEntry::name)) return "probe";
    if (has(scene.gradients, &GradientEntry::name)) return "gradient";
    return "";
}

/// Returns what is wrong with splitting the charts of a light map beside its other settings, or an empty text.
std::string whyNotSplit(const Scene& scene, const LightMapEntry& entry) {
    const OutputSettings& output = scene.output;
    for (const std::string& name : splitNamesOf(entry.name))
        if (const std::string_view kind = name == entry.name ? "" : kindOfAsset(scene, name); !kind.empty())
            return fmt::format("found charts to split beside a {} '{}', expected another name for that one: a map of the split has it",
                               kind, name);
    if (layoutAsked(output) != kAutoLayout || !(output.limits[Limit::Error] || visibleLimit(output, entry)))
        return fmt::format("found charts to split without a limit within which each map gets a layout, expected max_visible or max_error{}",
                           layoutAsked(output) == kAutoLayout ? "" : ", and light_map_layout = \"auto\" or none");
    if (output.cost != formats::LayoutCost::Bytes)
        return fmt::format("found charts to split beside cost = \"{}\", expected cost = \"bytes\": more maps save bytes alone",
                           formats::info(output.cost).name);
    return "";
}

/// Returns what is wrong with packing or splitting the charts of a light map of a scene, or an empty text.
std::string whyNotCharts(const Scene& scene, const LightMapEntry& entry) {
    const std::string why = isPacked(scene.output, entry) ? whyNotPacked(scene.output, entry) : "";
    return why.empty() && isSplit(scene.output, entry) ? whyNotSplit(scene, entry) : why;
}

}  // namespace

formats::Result<void> checkCharts(const Scene& scene, const ChartSettings& asked) {
    const auto hasPacked = [&](const LightMapEntry& entry) { return isPacked(scene.output, entry); };
    const bool isAnyPacked = std::ranges::any_of(scene.lightMaps, hasPacked);
    if (asked.maxVisible && !isAnyPacked)
        return formats::failure(formats::ErrorCode::InvalidRequest, "--charts-max-visible",
                                "found it where the charts of no light map are packed, expected --charts pack or split");
    for (const LightMapEntry& entry : scene.lightMaps) {
        const std::string why = whyNotCharts(scene, entry);
        if (why.empty()) continue;
        const std::string place = asked.mode ? "--charts" : placeIn(scene, "light_map", entry.name, "charts", "charts");
        return formats::failure(formats::ErrorCode::InvalidRequest, fmt::format("{}, light map '{}'", place, entry.name), why);
    }
    if (asked.mode) return {};  // it may say otherwise of charts than the limits of the scene file
    const auto refuse = [&](std::string_view section, const std::string& name) {
        return formats::failure(formats::ErrorCode::InvalidRequest,
                                placeIn(scene, section, name, "charts_max_visible", "--charts-max-visible"),
                                "found charts_max_visible where no charts are packed, expected charts = \"pack\" or \"split\"");
    };
    for (const LightMapEntry& entry : scene.lightMaps)
        if (entry.charts.maxVisible && !hasPacked(entry)) return refuse("light_map", entry.name);
    if (scene.output.charts.maxVisible && !isAnyPacked) return refuse("output", "");
    return {};
}

}  // namespace lightcook::pipeline
