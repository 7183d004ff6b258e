// scene.toml as it is read: the assets to cook, with units, sign convention, frame and colour space. Each struct is followed by its keys,
// from which the reader and docs/reference/scene-file.md are derived; settings.h resolves what a scene leaves open.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/bake_format.h"
#include "formats/color.h"
#include "formats/error.h"
#include "formats/gpu_texture.h"
#include "formats/layout_cost.h"
#include "formats/light_map.h"
#include "formats/light_map_conventions.h"
#include "formats/light_map_objective.h"
#include "formats/lmbake.h"
#include "formats/probe_place.h"
#include "formats/specular_lobe.h"
#include "formats/target.h"
#include "lighting/display.h"
#include "pipeline/document/enum_names.h"
#include "pipeline/document/given_keys.h"
#include "pipeline/document/json.h"
#include "pipeline/document/keys.h"
#include "pipeline/limits/limits.h"
#include "pipeline/scene/chart_settings.h"
#include "pipeline/scene/checks.h"
#include "pipeline/scene/cubemap_layout.h"
#include "pipeline/scene/dominant_fit.h"
#include "pipeline/scene/dominant_layout.h"
#include "pipeline/scene/lint_checks.h"
#include "pipeline/scene/rsrm_format.h"
#include "pipeline/scene/scene_lines.h"
#include "pipeline/scene/up_axis.h"

namespace lightcook::pipeline {

using formats::Target;

/// Returns the names of the light-map layouts, as `light_map_layout` and `--layout` take them, without "auto".
const std::vector<std::string>& lightMapLayoutNames();
/// Returns the same names and "auto".
const std::vector<std::string>& lightMapLayoutChoices();
/// Selects the smallest layout that meets the error, or the one of least error within the budget.
inline constexpr const char* kAutoLayout = "auto";

/// Return what is wrong with a text as "found ..., expected ...", or an empty text: with the name of an asset or scene, which becomes part
/// of file names; with a bake format that is a GPU layout.
std::string faultOfName(const std::string& name);
std::string faultOfBake(const std::string& bake);

// Values that several keys have.
inline const KeyRule kPositiveFraction = {.isFraction = true,
                                          .allows = [](double value) { return value > 0; },
                                          .expected = "a positive fraction: 0.02, or \"2%\"",
                                          .type = "fraction"};
inline const KeyRule kMips = {.expected = "true or false: the charts of a map decide how many levels it has"};
inline const KeyRule kChartsVisible = {
    .low = 0, .high = kMostChartsVisible, .expected = fmt::format("a number from 0 (charts are moved only) to {:g}", kMostChartsVisible)};
inline const KeyRule kLayouts = {
    .expected = "a list of light-map layouts, such as [\"godot\", \"sh4\"]", .type = "list", .shape = KeyShape::Texts};
inline const KeyRule kTargets = {.expected = "a list of targets, such as [\"bc\", \"astc\"]", .type = "list", .shape = KeyShape::Texts};
inline const KeyRule kAssetName = {.faultOf = faultOfName};
inline const KeyRule kColorSpace = {.expected = "the name of a colour space"};

class TomlValue;
struct LightMapEntry;
struct Scene;
/// Read the keys that are neither numbers nor texts.
formats::LayoutList readLayouts(const TomlValue& value);
std::vector<std::string> readTargets(const TomlValue& value);
void readFiles(const TomlValue& value, LightMapEntry& entry);
void readAllowances(const TomlValue& value, Scene& scene);

inline constexpr double kLargestRdo = 1;

/// The section [output], with the overrides of the command line.
struct OutputSettings {
    Target target = Target::Bc;
    formats::Container container = formats::Container::Ktx2;
    std::string lightMapLayout;  ///< one of lightMapLayoutNames(), "auto", or empty: see layoutAsked
    Limits limits;               ///< see limitsOf, converterLimits and wholeLimits
    /// Returns true if a limit on the error of light maps is given.
    bool isErrorLimited() const { return limits.isAny(kAssetLimits); }
    std::optional<std::uint64_t> budgetBytes;  ///< of GPU memory for the whole scene
    /// Returns true if light maps and their dominant lights are chosen together, by what a pixel shows.
    bool isChosenByWhole() const { return budgetBytes || isWholeLimited(); }
    bool isWholeLimited() const { return limits.isAny({Limit::WholeVisible, Limit::WholeError}); }
    double rdo = 0;  ///< share by which the error may grow so that blocks repeat, 0 .. kLargestRdo; target bc only
    formats::Objective objective = formats::Objective::Visible;  ///< of learned layouts of light maps
    formats::LayoutCost cost = formats::LayoutCost::Bytes;       ///< of layouts, where "auto" chooses one within an error
    formats::DecodeLimits decode = {};                           ///< of layouts
    std::optional<bool> detail = {};   ///< tiles of light maps may have detail; absent: where "auto" chooses the layout
    formats::LayoutList layouts = {};  ///< that "auto" may take
    int effort = 5;                    ///< of block encoders, 0 .. 9
    bool keepUnused = false;           ///< cooks also what no material, surface or shading shows
    bool zstd = false;
    bool draco = true;  ///< meshes as Draco inside glTF
    bool gltf = false;  ///< also writes the scene as glTF with its light maps bound
    bool mips = false;  ///< light maps have as many mip levels as keep their charts apart; dominant lights have one
    ChartSettings charts = {};
};
template <class Keys>
void describeKeys(Keys& keys, OutputSettings& output) {
    keys.optional("target", output.target, {}, withCaptions("family of GPU formats", formats::allTargets()));
    keys.special("targets", kTargets.before("output.target"),
                 "several targets in place of one, `[\"bc\", \"astc\"]`: each is cooked into a folder of its own, `DIR/bc` and `DIR/astc`. "
                 "A table `[target.astc]` of the scene file has limits and a budget for one of them "
                 "([several targets](../guide/memory-budgets.md#several-targets))",
                 [](const auto& value) { readTargets(value); });
    keys.optional(
        "max_error", output.limits[Limit::Error], kPositiveFraction.otherwise("none; of meshes 0.1"),
        "limit on `rel_rms` of diffuse and of specular light, of light maps and meshes, such as `0.02` or `\"2%\"`; above it "
        "verification fails (exit code 4), and a limit below what the bake itself loses is refused [at once](../theory/error.md#floor)");
    keys.optional("max_converter_error", output.limits[Limit::ConverterError],
                  kPositiveFraction.otherwise("0.1, of cubemaps 0.5, or `max_error` if that is larger"),
                  "limit of dominant lights, cubemaps, tables and reflection maps, each on its own quantity");
    keys.optional(
        "max_visible", output.limits[Limit::Visible],
        kVisibleLimit.otherwise(
            "5 where the layout is `\"auto\"` and none of `max_error`, `max_visible_bound`, `max_whole_visible`, "
            "`max_whole_error` and `budget` is given, else none. The default chooses the layout; where none keeps it, the best "
            "one passes"),
        "limit on the [visible error](../theory/visible.md) of light maps and meshes, in just noticeable differences: 99 % of the "
        "samples are within it; above it verification fails (exit code 4)");
    keys.optional("max_visible_bound", output.limits[Limit::VisibleBound], kVisibleLimit,
                  "limit on the [proven bound](../theory/bounds.md#visible-errors) of the visible error of light maps and meshes, in just "
                  "noticeable differences: no place, normal or view is above it; else verification fails (exit code 4)");
    keys.optional("max_seam", output.limits[Limit::Seam], kVisibleLimit,
                  "limit on the [seams](../theory/visible.md#seams) that cooking adds where charts of a light map meet on its mesh, "
                  "in just noticeable differences; above it verification fails (exit code 4)");
    keys.optional(
        "max_whole_visible", output.limits[Limit::WholeVisible], kVisibleLimit,
        "limit on the visible error (p99) of what a pixel shows of a light map and its dominant light together. Their layouts are "
        "chosen together, [the smallest within it](../guide/memory-budgets.md#a-limit-in-place-of-a-budget); above it "
        "verification fails (exit code 4)");
    keys.optional("max_whole_error", output.limits[Limit::WholeError], kPositiveFraction,
                  "limit on `rel_rms` of what a pixel shows of a light map and its dominant light together, likewise");
    keys.optional("max_converter_visible", output.limits[Limit::ConverterVisible], kVisibleLimit,
                  "limit on the visible error of dominant lights, cubemaps, tables and reflection maps, each in the "
                  "[light that it adds to a pixel](../theory/visible.md#other-assets)");
    keys.optional("max_converter_visible_bound", output.limits[Limit::ConverterVisibleBound], kVisibleLimit,
                  "limit on the proven bound of dominant lights, cubemaps, tables and reflection maps. That of a dominant light is always "
                  "[the largest difference of the display](../theory/bounds.md#the-largest-difference-of-a-display)");
    keys.optional("budget", output.budgetBytes, kByteCount,
                  "GPU memory of the whole scene: `\"2 MiB\"`, `\"1.5 GB\"`, `\"4096\"` (bytes); more is exit code 5");
    keys.optional("light_map_layout", output.lightMapLayout,
                  {.names = lightMapLayoutChoices(), .fallback = inCode(kAutoLayout), .option = "layout"},
                  "[layout](../theory/layouts.md) of the light maps; `auto`: the one that meets the limits or the budget best");
    keys.optional("cost", output.cost, {},
                  withCaptions("what `auto` keeps small where an error limits it; [light-map layouts](light-map-layouts.md) has the costs",
                               formats::allLayoutCosts()));
    constexpr double kMostDecodeCost = 1e6;
    const KeyRule decodeCost = {.low = 1, .high = kMostDecodeCost, .type = "integer"};
    keys.optional(
        "filter", output.decode.filter,
        KeyRule{}.otherwise("decoded where a layout's decode is not linear and is within the limits below, unless an engine's own "
                            "shader reads it, `cost` is `taps` or the map has `mips`; else hardware. Under `max_visible_bound` decoded for "
                            "every layout that "
                            "can be"),
        withCaptions("[how light between texels](../theory/layouts.md#decoded-before-the-filter) follows from theirs",
                     formats::allLightMapFilters()));
    keys.optional("detail", output.detail, KeyRule{}.otherwise("true where the layout is `\"auto\"`, else false"),
                  "store tiles of a light map once more in layout `lit` where the map errs most, as many as bring it within the limit on "
                  "the visible error ([detail](../theory/layouts.md#detail)); for filter `decoded`");
    keys.optional("max_fetches", output.decode.maxFetches, decodeCost,
                  "limit on the texture fetches of a light map's sample: `auto` takes no other layout");
    keys.optional("max_decode_ops", output.decode.maxDecodeOps, decodeCost, "limit on the multiply-adds of its decode, likewise");
    keys.special(
        "layouts", kLayouts.otherwise("none: those that a trial measures"),
        "layouts that `auto` may take, which the engine reads: `[\"godot\", \"sh4\"]`. No other one stands in for them, not even a "
        "smaller one for bands that no shading shows. [From the trial](../guide/into-an-engine.md#layouts-that-the-engine-reads) "
        "the report says what the list costs",
        [&](const auto& value) { output.layouts = readLayouts(value); });
    keys.optional("objective", output.objective, {},
                  withCaptions("what learned layouts of light maps and ratio minimize", formats::allObjectives()));
    keys.optional("container", output.container, {}, "container of the textures");
    keys.optional("zstd", output.zstd, {}, "Zstandard supercompression of KTX2 levels");
    keys.optional("effort", output.effort, within(0, 9),
                  "effort of the block encoders: 0 is fastest, 9 best. Not beside target `float`, whose texels are not encoded");
    keys.optional(
        "rdo", output.rdo,
        {.isFraction = true, .low = 0, .high = kLargestRdo, .expected = "a fraction from 0 to 1: 0.02, or \"2%\"", .type = "0 to 1"},
        "target `bc`: share by which the error of a row of blocks may grow, for smaller files with `zstd` "
        "([encoding textures](../guide/encoding-textures.md#rate-distortion-optimization))");
    keys.optional(
        "draco", output.draco, {},
        "write meshes as Draco inside glTF, with the fewest bits that the limit allows "
        "([meshes](../guide/into-an-engine.md#meshes)). Without it a mesh is written only under a learned layout, unchanged except "
        "for the added attribute");
    keys.optional("charts", output.charts.mode, {.fallback = inCode(allChartModes().front().name)},
                  withCaptions("[charts](../guide/memory-budgets.md#fewer-texels) of the light maps; `\"pack\"` needs their meshes",
                               allChartModes()));
    keys.optional(
        "charts_max_visible", output.charts.maxVisible, kChartsVisible.otherwise("0"),
        "visible error that fewer texels of packed charts may add to 99 % of a chart's samples, in just noticeable differences. 0: "
        "charts are moved only, without loss");
    keys.optional("gltf", output.gltf, {},
                  "also write each light map with its mesh as glTF, with the light map bound "
                  "([glTF](../guide/into-an-engine.md#the-scene-as-gltf))");
    keys.optional("mips", output.mips, kMips.otherwise("false"),
                  "write the light maps with mip levels, from level 0 to the last that keeps their charts apart "
                  "([mip levels](../guide/into-an-engine.md#mip-levels)); the limits on the error hold for each level");
    keys.optional("keep_unused", output.keepUnused, {},
                  "cook also what the report would list as skipped for its content: each texel of a map of constant light, bands that no "
                  "shading shows, probes that no surface uses, rows of reflection maps that no material reads");
}

struct LightMapEntry {
    std::string name;
    std::filesystem::path file;
    formats::LightMapDescription description;
    std::optional<std::filesystem::path> mesh;
    std::string dominantFit = "explained";             ///< a name of allDominantFits()
    std::optional<std::string> dominantLayout = {};    ///< a name of allDominantLayouts(); absent: usualDominantLayout()
    Limits limits;                                     ///< override those of the output
    std::optional<std::filesystem::path> groundTruth;  ///< traced light at texels of the map (formats::readShadingValues)
    formats::LayoutList layouts = {};                  ///< that "auto" may take; empty: those of the output
    std::optional<bool> mips = {};                     ///< overrides that of the output
    ChartSettings charts = {};                         ///< override those of the output
};
template <class Keys>
void describePlace(Keys& keys, formats::NodePlace& place) {
    const KeyRule two = {.low = -formats::kMostPlace, .high = formats::kMostPlace, .type = "two numbers"};
    keys.required(
        "node", place.node, {.expected = "the name of a node of the mesh"},
        "name of a node, or the end of its path as in `\"Room/Wall\"`. Nodes below it count too, unless they have a place of their "
        "own");
    KeyRule scale = two.otherwise("[1, 1]");
    scale.expected = fmt::format("factors [x, y] of the UVs other than 0, up to {:g}", formats::kMostPlace);
    scale.allows = [](double factor) { return factor != 0; };
    keys.optional("scale", place.scale, scale, "factors of the node's light-map UVs");
    KeyRule offset = two.otherwise("[0, 0]");
    offset.expected = fmt::format("shares [x, y] of the map up to {:g}", formats::kMostPlace);
    keys.optional("offset", place.offset, offset, "what is added to them then: UVs in the map are `uv * scale + offset`, with v down");
}

template <class Keys>
void describeKeys(Keys& keys, LightMapEntry& entry) {
    formats::LightMapDescription& description = entry.description;
    keys.required("name", entry.name, kAssetName,
                  "name of the asset and its files: up to 128 letters, digits, `_`, `-` and `.`. Names of light maps, probes and gradients "
                  "differ in more than the case of letters");
    keys.requiredUnless("files", "file", entry.file, {},
                        "EXR, tiled or scan-line, half or float; or Radiance HDR; or an 8-bit picture with an `encoding`; or a glTF of "
                        "Unreal. Of a bake of several files any one of them: the others are found beside it");
    std::string bakes =
        fmt::format("format of the file. `{}`: by its channels, its name, its size and the files beside it", formats::kAutoBake);
    for (const formats::BakeFormatInfo& row : formats::allBakeFormats()) bakes += fmt::format("; `{}`: {}", row.name, row.caption);
    keys.optional("bake", description.bake, {.names = formats::bakeNames(), .faultOf = faultOfBake}, bakes);
    keys.special(
        "files", {.type = "table of paths", .shape = KeyShape::Table},
        "in place of `file`: one image for each coefficient, `{ sh00 = \"a.exr\", sh01 = \"b.exr\", ... }` to `sh03` or `sh08`, or "
        "one for each colour, `{ sh00 = { R = \"r.exr\", G = \"g.exr\", B = \"b.exr\" }, ... }`. The first may have the channels "
        "of coverage and normal",
        [&](const auto& value) { readFiles(value, entry); });
    const auto convention = [&](const char* key, auto& value, std::string_view what) {
        keys.optional(key, value, {}, withCaptions(what, formats::conventions<std::remove_reference_t<decltype(value)>>()));
    };
    convention("phase", description.phase, "sign convention");
    convention("frame", description.frame, "axes of the coefficients");
    keys.optional("axes", description.axes, {.type = "three of `x`, `y`, `z`, each with or without `-`"},
                  "components of the file's vectors that are x, y and z of the mesh: `\"-x,y,z\"` for Unity, `\"x,z,-y\"` for a baker that "
                  "is Z up. Turns coefficients, directions and normals of the file; of `frame = \"tangent\"`, the normals that the frames "
                  "are of. It brings the bake into the world of the mesh; `up_axis` says which axis of that world points up, and neither "
                  "changes the other");
    keys.optional("output_axes", description.outputAxes, {.type = "three of `x`, `y`, `z`, each with or without `-`"},
                  "of a layout that an engine reads: components of a vector in the axes of the mesh that are x, y and z in those of the "
                  "engine's shader: `\"-x,y,z\"` for Unity, where glTF has -x. The cooked light, its errors and its normals are in them");
    convention("quantity", description.quantity, "quantity that the coefficients expand");
    convention("light_units", description.lightUnits, "units of the bake's light sources");
    convention("encoding", description.encoding,
               fmt::format("encoding of the colours of a picture of 8 or 16 bits (PNG, TGA, TIFF), for the bake formats {}",
                           fmt::join(formats::encodedBakeNames(), ", ")));
    convention("coverage", description.coverage, "what says which texels lie inside charts");
    keys.optional("image", description.image, {.expected = "the name of an image in the glTF"},
                  fmt::format("name or index of the image of a glTF that has light maps in several, for bake format {}",
                              fmt::join(formats::gltfBakeNames(), ", ")));
    keys.optional(
        "firefly_limit", description.fireflyLimit, kFireflyLimit,
        "largest ratio of a texel to its brightest neighbour; above it the texel is a firefly. At the rim of a chart it is the third "
        "power of this. 0: no test (charts of one texel are never tested)");
    keys.optional("dominant_fit", entry.dominantFit, oneOf(allDominantFits()),
                  withCaptions("method of the [dominant light](../theory/lighting.md#dominant-light)", allDominantFits()));
    keys.optional("dominant_layout", entry.dominantLayout, oneOf(allDominantLayouts()).otherwise("none; see right"),
                  withCaptions("where shaders have the dominant light from", allDominantLayouts()) +
                      ". Absent: `\"derived\"`; `\"full\"` with another `dominant_fit` than `explained`, or with a light-map layout that "
                      "an engine reads or that lacks directions or band 2");
    keys.optional("max_visible", entry.limits[Limit::Visible], kVisibleLimit.before("output.max_visible"),
                  "limit on the visible error of this light map, and of its mesh");
    keys.optional("max_visible_bound", entry.limits[Limit::VisibleBound], kVisibleLimit.before("output.max_visible_bound"),
                  "limit on the proven bound of the visible error of this light map, and of its mesh");
    keys.special("layouts", kLayouts.before("output.layouts"), "layouts that `auto` may take for this light map",
                 [&](const auto& value) { entry.layouts = readLayouts(value); });
    keys.optional("charts", entry.charts.mode, KeyRule().before("output.charts"), "what happens to the charts of this light map");
    keys.optional("charts_max_visible", entry.charts.maxVisible, kChartsVisible.before("output.charts_max_visible"),
                  "visible error that fewer texels of its packed charts may add");
    keys.optional("max_seam", entry.limits[Limit::Seam], kVisibleLimit.before("output.max_seam"),
                  "limit on the added seams of this light map; it needs a `mesh`");
    keys.optional("mips", entry.mips, kMips.before("output.mips"), "write this light map with mip levels");
    keys.optional("ground_truth", entry.groundTruth, {},
                  "CSV of light traced at texels of the map, to separate truncation, fit and quantization "
                  "([format](../theory/error.md#ground-truth))");
    keys.optional("mesh", entry.mesh, {},
                  fmt::format("glTF or GLB whose `TEXCOORD_1` is the light-map UV. Its materials decide what the scene needs. A learned "
                              "layout keeps each of its islands under one basis ([clusters](../theory/layouts.md#clusters-in-the-mesh)). "
                              "Bake formats {} are relative to its surfaces and need it",
                              fmt::join(formats::meshBakeNames(), ", ")));
    keys.optional(
        "surfaces", description.mesh, {.fallback = "that of `mesh`", .option = "mesh"},
        fmt::format("the glTF whose surfaces the bake lies on, for normals that the file lacks, `coverage = \"mesh\"` and bake formats "
                    "{} alone: nothing else of it counts, and it is not cooked",
                    fmt::join(formats::meshBakeNames(), ", ")));
    const std::string noLmbake(formats::kNoLmbake);
    keys.special("lmbake",
                 {.names = {noLmbake},
                  .type = fmt::format("path, or {}", inCode(noLmbake)),
                  .fallback = "the file beside the bake with the extension `.lmbake`",
                  .shape = KeyShape::Path},
                 fmt::format("of a bake of Godot ({}): the file that says which rectangle of the map each node of the `mesh` has. {}: "
                             "`TEXCOORD_1` are UVs in the whole map already",
                             fmt::join(formats::lmbakeBakeNames(), ", "), inCode(noLmbake)),
                 [&](const auto& value) {
                     const std::string expected = fmt::format("a path, or \"{}\"", noLmbake);
                     description.hasNoLmbake = value.text(expected) == noLmbake;
                     if (!description.hasNoLmbake) description.lmbake = value.path(expected);
                 });
    keys.sectionsInside(
        "place", description.places, {.fallback = "none: the map lies on all nodes"},
        "nodes of the `mesh` that the map lies on, each in a table `[[light_map.place]]`",
        {.intro = "A node of the mesh that the light map above lies on. Nodes without a place are not of this map, and its cooked mesh "
                  "leaves them out: one glTF may have a light map for each of its nodes, or rectangles of one map.",
         .outro = "[From a baker to a scene](../guide/from-a-baker-to-a-scene.md#one-mesh-several-light-maps) says what Unity, bevy and "
                  "other bakers call these."},
        [](auto& inner, auto& place) { describePlace(inner, place); });
}

/// Value of `size` of a probe that leaves out the levels that no material reads.
inline constexpr std::string_view kAutoProbeSize = "auto";

/// Describes the limits of an asset that is no light map.
/// what  "this cubemap"
template <class Keys>
void describeLimits(Keys& keys, Limits& limits, std::string_view what) {
    keys.optional("max_visible", limits[Limit::Visible], kVisibleLimit.before("output.max_converter_visible"),
                  fmt::format("limit on the visible error of {}", what));
    keys.optional("max_visible_bound", limits[Limit::VisibleBound], kVisibleLimit.before("output.max_converter_visible_bound"),
                  fmt::format("limit on the proven bound of the visible error of {}", what));
}

struct ProbeEntry {
    std::string name;
    std::filesystem::path file;
    std::optional<std::filesystem::path> sh;  ///< JSON that holds the probe's SH; projected from the image without it
    int size = 128;                           ///< of a face [texels]: a power of two, kLeastProbeSize .. kMostProbeSize
    bool readLevelsOnly = true;               ///< leave out the large levels that no material reads
    std::string layout = "pre-divided";       ///< a name of allCubemapLayouts()
    formats::ProbePlace place = {};           ///< goes before that of the file `sh`
    Limits limits = {};                       ///< override those on visible errors of converters of the output
};
template <class Keys>
void describeKeys(Keys& keys, ProbeEntry& probe) {
    keys.required("name", probe.name, kAssetName, "name of the asset");
    keys.required("file", probe.file, {},
                  "equirectangular panorama, or six faces as a strip, a cross or six files "
                  "([shapes](../guide/from-a-baker-to-a-scene.md#probes)); EXR or Radiance HDR");
    keys.optional("sh", probe.sh, {.fallback = "projected from the image"},
                  "JSON with the probe's own SH, found by the image's file name: "
                  "`{\"probes\": [{\"file\": \"...\", \"sh\": [[r, g, b], ... nine]}]}`");
    const std::string automatic = inCode(kAutoProbeSize);
    keys.special(
        "size",
        {.type = fmt::format("a power of two, {} to {}, or {}", kLeastProbeSize, kMostProbeSize, automatic),
         .fallback = automatic,
         .shape = KeyShape::Integer},
        fmt::format("texels along the edge of a face. The levels go down to one texel a face. {}: the levels of {} less the largest "
                    "ones, if the materials are too rough to read them",
                    automatic, probe.size),
        [&](const auto& value) {
            const std::string expected =
                fmt::format("a power of two from {} to {}, or \"{}\"", kLeastProbeSize, kMostProbeSize, kAutoProbeSize);
            if (value.isText()) {
                value.oneOf({std::string(kAutoProbeSize)}, expected);
                return;
            }
            const std::int64_t size = value.integer(expected);
            if (objectionToProbeSize(size)) value.refuse(fmt::format("{}", size), expected);
            probe.size = static_cast<int>(size);
            probe.readLevelsOnly = false;
        });
    keys.optional("layout", probe.layout, oneOf(allCubemapLayouts()), withCaptions("what a texel holds", allCubemapLayouts()));
    const std::string ofFile = "that of the file `sh`";
    keys.optional("position", probe.place.position, {.expected = "a place [x, y, z]", .type = "`[x, y, z]`", .fallback = ofFile},
                  "world place of the probe, for the manifest");
    keys.special("box", {.type = "six numbers", .fallback = ofFile, .shape = KeyShape::Numbers},
                 "room that an engine corrects reflections for: lowest corner, then highest corner. In the JSON `[[x, y, z], [X, Y, Z]]`",
                 [&](const auto& value) {
                     const char* const expected = "the corners [x, y, z, X, Y, Z] of a box, the lowest first";
                     const std::vector<double> all = value.numbers(expected);
                     if (all.size() == 6) probe.place.box = {glm::dvec3(all[0], all[1], all[2]), glm::dvec3(all[3], all[4], all[5])};
                     if (all.size() != 6 || !formats::objectionToProbePlace(probe.place).empty())
                         value.refuse(fmt::format("[{}]", fmt::join(all, ", ")), expected);
                 });
    keys.optional("radius", probe.place.radius,
                  {.allows = [](double radius) { return radius > 0; }, .expected = "a positive radius", .fallback = ofFile},
                  "radius of the sphere that the probe lights");
    describeLimits(keys, probe.limits, "this cubemap");
}

/// Values of `encoding` of a gradient, and of `rsrm --encoding`.
inline const std::vector<std::string> kGradientEncodings = {"auto", "linear", "srgb"};
inline constexpr int kMostGradientZones = 4096;

struct GradientEntry {
    std::string name;
    std::filesystem::path file;
    std::vector<double> exponents = {1, 4, 16, 64, 256, 1024, 4096, 16384};
    std::string encoding = "auto";        ///< one of kGradientEncodings; for painted gradients only
    std::optional<glm::dvec3> axis = {};  ///< the file is an environment, averaged around this world direction
    int zones = 256;                      ///< of the average around the axis
    std::string format = {};              ///< one of rsrmFormatChoices(); empty: see rsrmFormatsToTry
    bool dither = false;                  ///< rgba8 alone
    Limits limits = {};                   ///< override those on visible errors of converters of the output
};
template <class Keys>
void describeKeys(Keys& keys, GradientEntry& gradient) {
    keys.required("name", gradient.name, kAssetName, "name of the asset");
    keys.required("file", gradient.file, {},
                  "painted: N x 1 texels of equal solid angle, from the axis (north) to its opposite, HDR or 8 bits; or, with `axis`, an "
                  "environment as a probe's");
    keys.special(
        "exponents",
        {.type = "numbers, 1 to 65536", .fallback = fmt::format("`[{}]`", fmt::join(gradient.exponents, ", ")), .shape = KeyShape::Numbers},
        "Phong exponents, one row each; 1 is Lambert exit radiance", [&](const auto& value) {
            gradient.exponents = value.numbers("1 to 256 increasing Phong exponents from 1 to 65536");
            value.check(objectionToExponents(gradient.exponents));
        });
    keys.optional(
        "encoding", gradient.encoding, oneOf(kGradientEncodings),
        "encoding of painted gradients. `auto`: the sRGB curve for PNG, JPEG, TGA and BMP, linear for others. The primaries are those of "
        "`color.source` either way");
    keys.special("axis", {.type = "`[x, y, z]`", .shape = KeyShape::Numbers},
                 "the file is an environment, averaged around this world direction "
                 "([loss](../theory/lighting.md#radially-symmetric-reflection-maps))",
                 [&](const auto& value) {
                     const std::vector<double> axis = value.numbers("a direction [x, y, z] other than zero");
                     value.check(objectionToAxis(axis));
                     gradient.axis = directionOfAxis(axis);
                 });
    keys.optional("zones", gradient.zones, within(1, kMostGradientZones), "with `axis`: number of zones of equal solid angle");
    keys.optional(
        "format", gradient.format,
        oneOf(rsrmFormatChoices())
            .otherwise(
                fmt::format("{} where it keeps the error limit, else {}", inCode(info(RsrmFormat::Rgba8).name), inCode(kAutoRsrmFormat))),
        fmt::format("{}. `{}`: the smallest format of the target that keeps `max_converter_error`, both as `rel_rms` and as `p99` "
                    "at texel centres. `bc7`, `bc4` and `bc6h` are for target `bc` alone; their rows count in fours. "
                    "[Which one](../theory/lighting.md#radially-symmetric-reflection-maps) holds a sun",
                    withCaptions("format of the texels", allRsrmFormats()), kAutoRsrmFormat));
    keys.optional("dither", gradient.dither, {},
                  "with `rgba8`, rounding errors are carried to the next texel of the row, so that slow gradients have no bands");
    describeLimits(keys, gradient.limits, "this reflection map");
}
/// Adds to a material of the glTF, or overrides it; the name "*" is every material.
struct MaterialEntry {
    std::string name;
    std::optional<bool> normalMap, specular;
    std::optional<Range> m, f0;
    std::optional<double> normalMapTilt = {};  ///< largest angle of a normal map's normal from the surface's [degrees]
};
template <class Keys>
void describeKeys(Keys& keys, MaterialEntry& material) {
    const KeyRule ofGltf = {.fallback = "from the glTF"};
    const KeyRule share = {.low = 0,
                           .high = 1,
                           .expected = "[low, high] with 0 <= low <= high <= 1",
                           .type = "two numbers in [0, 1]",
                           .fallback = "from the glTF"};
    keys.required("name", material.name, {.expected = "a material's name, or \"*\""},
                  "name of a material in the glTF, once in the file; `\"*\"` is every material");
    keys.optional("normal_map", material.normalMap, ofGltf, "false and no specular: a flat map is enough");
    keys.optional("normal_map_tilt", material.normalMapTilt,
                  {.low = kLeastNormalMapTilt,
                   .high = kMostNormalMapTilt,
                   .expected = fmt::format("an angle from {} to {} degrees, or normal_map = false for surfaces without normal maps",
                                           kLeastNormalMapTilt, kMostNormalMapTilt),
                   .fallback = "60"},
                  "largest angle between a normal of the normal map and that of the surface [degrees]. Visible errors are measured and "
                  "bounded up to the largest angle of all materials");
    keys.optional("specular", material.specular, ofGltf, "false: no dominant light, no tables, no cubemaps");
    keys.optional("m", material.m, share, "the range of roughness: m of Beckmann, alpha of GGX (glTF: `roughnessFactor` squared)");
    keys.optional("f0", material.f0, share, "the range of reflectance at normal incidence");
}

inline const std::vector<std::string> kNormalizationNames = {"energy", "halo3"};
inline constexpr int kMostTableNodes = 1024;  ///< columns, or rows

/// Views of the tables. With 24, 3 KiB more than the 8 of Chen and Liu 2008, they cause less than 2 % of the squared error of the whole
/// shading in place of 25 to 42 %.
inline constexpr int kFineViewCount = 24;
inline constexpr int kLeastViewCount = 8;  ///< under a budget whose layouts leave no room for more
/// Return "auto" and the names of fit::viewMappings() or fit::roughnessMappings().
std::vector<std::string> viewAxisNames();
std::vector<std::string> roughnessAxisNames();

/// Settings of the specular tables. The analytic light of the shaders agrees with the default normalization.
struct TableSettings {
    std::optional<int> viewCount;          ///< absent: see areViewsOpen and viewCountOf
    std::optional<int> roughnessCount;     ///< over exactly the range of m; else those of the 16 rows 1/16 to 1 that it needs
    std::string normalization = "energy";  ///< or halo3, four times as bright
    std::string viewAxis = "auto", roughnessAxis = "auto";  ///< fit::viewMappings(), fit::roughnessMappings()
    Limits limits = {};                                     ///< override those on visible errors of converters of the output
};
template <class Keys>
void describeKeys(Keys& keys, TableSettings& tables) {
    keys.optional(
        "views", tables.viewCount,
        within(2, kMostTableNodes)
            .otherwise(fmt::format("{1}; with `budget` {1} where the layouts leave room, else {0}", kLeastViewCount, kFineViewCount)),
        "number of columns, for views");
    keys.optional("rows", tables.roughnessCount, within(1, kMostTableNodes).otherwise("those of 16, m 1/16 to 1, that the materials need"),
                  "number of rows, spread over exactly the range of m of the materials");
    keys.optional("normalization", tables.normalization, oneOf(kNormalizationNames),
                  "`energy`: energy conserving; `halo3`: four times as bright");
    keys.optional("view_axis", tables.viewAxis, oneOf(viewAxisNames()),
                  "quantity along columns; `auto`: the one with the least interpolation error");
    keys.optional("roughness_axis", tables.roughnessAxis, oneOf(roughnessAxisNames()), "quantity along rows");
    describeLimits(keys, tables.limits, "the tables");
}

template <class Keys>
void describeColor(Keys& keys, formats::ColorSpaces& colors) {
    keys.optional("source", colors.source, kColorSpace,
                  "colour space of the files; `\"stated\"`: for each file what it states (`chromaticities` of OpenEXR, `PRIMARIES` of "
                  "Radiance), else lin_rec709");
    keys.optional("working", colors.working, kColorSpace, "colour space of the engine");
    keys.optional("config", colors.config, {.fallback = "built in"}, "OpenColorIO configuration that has both");
}

template <class Keys>
void describeDisplay(Keys& keys, lighting::DisplaySettings& display) {
    using namespace lighting;
    keys.optional("white", display.white,
                  {.low = kLeastWhite,
                   .high = kMostWhite,
                   .expected = fmt::format("a positive exit radiance, from {:g} to {:g}", kLeastWhite, kMostWhite),
                   .type = "number from 1e-9 to 1e9",
                   .fallback = "none: the key of each light map is shown at 18 % of diffuse white"},
                  "exit radiance that the game shows as diffuse white, 203 cd/m^2");
    keys.optional("stops", display.stops, within(-kMostStops, kMostStops), "exposure compensation: light is shown 2^stops as bright");
    keys.optional(
        "black", display.black,
        {.low = kLeastBlack, .high = kMostBlack, .expected = fmt::format("a luminance from {} to {} cd/m^2", kLeastBlack, kMostBlack)},
        "luminance of the display's black in its room, in cd/m^2");
}

struct Scene {
    std::filesystem::path file;       ///< path of scene.toml as given
    std::filesystem::path directory;  ///< paths of the scene are relative to it
    std::string name;
    OutputSettings output;
    formats::ColorSpaces colors;
    lighting::DisplaySettings display;
    std::vector<LightMapEntry> lightMaps;
    std::vector<ProbeEntry> probes;
    std::vector<GradientEntry> gradients;
    std::vector<MaterialEntry> materials;
    TableSettings tables;
    SceneLines lines;  ///< of the scene file
    /// Specular lobe of cubemaps, tables, dominant lights, shader and verification: one of formats::sceneLobes(), or, of a scene of tables
    /// alone, any.
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;
    std::vector<Allowance> allowances;  ///< key `allow`
    UpAxis up = UpAxis::Y;              ///< of world space: the axis of painted gradients
    /// What the scene was read from: the file with the keys of the command line over its own. readSceneDocument makes the same scene of it.
    Json document = {};
    bool isOfTargets = false;  ///< one of `output.targets`, which has a folder of its own: see cookedFolder
};
template <class Keys>
void describeKeys(Keys& keys, Scene& scene) {
    int schema = 1;
    keys.required("schema", schema, {.low = 1, .high = 1, .expected = "schema = 1", .type = "integer"}, "`1`: the version of this format");
    keys.required("name", scene.name, kAssetName, "name of the scene, in manifest and report");
    keys.optional("lobe", scene.lobe, {},
                  withCaptions("[specular lobe](../theory/lighting.md#specular-tables) of cubemaps, tables, dominant lights, shader and "
                               "verification: that of the engine's materials. Scenes of tables alone have the Phong lobes, too",
                               formats::allSpecularLobes()));
    keys.optional("up_axis", scene.up, {},
                  withCaptions("axis of world space that points up: that of painted gradients. It is for the manifest and the camera of "
                               "`view`; nothing is turned",
                               allUpAxes()));
    keys.special("target", {.type = "tables", .shape = KeyShape::Table},
                 "`[target.NAME]`: keys of `[output]` for that target alone, which go before those there",
                 [](const auto&) {});  // taken before a scene is read of the other keys: see readScenes
    const auto describe = [](auto& inner, auto& value) { describeKeys(inner, value); };
    keys.section("output", scene.output, {}, describe);
    keys.section(
        "color", scene.colors,
        {.outro = "[Colour](../theory/lighting.md#colour) lists the built-in spaces. Conversions that are not linear are refused."},
        [](auto& inner, auto& colors) { describeColor(inner, colors); });
    keys.section("display", scene.display,
                 {.outro = "How the game shows the scene: [visible errors](../theory/visible.md) are judged there."},
                 [](auto& inner, auto& display) { describeDisplay(inner, display); });
    keys.sections(
        "light_map", scene.lightMaps,
        {.outro = "[From a baker to a scene](../guide/from-a-baker-to-a-scene.md#light-maps) lists the values that are refused, and "
                  "`--repair`."},
        describe);
    keys.section("tables", scene.tables,
                 {.intro = "Specular tables, made where a material is specular. `lightcook lut` has the same options."}, describe);
    keys.sections("probe", scene.probes, {}, describe);
    keys.sections("gradient", scene.gradients, {}, describe);
    keys.sections("material", scene.materials, {.intro = "Adds to the glTF's materials, or overrides them."}, describe);
    keys.special("allow", {.type = "list", .shape = KeyShape::Table},
                 "warnings of [lint](../guide/lint.md) that are right as they are: `[\"code\"]`, or "
                 "`[{ code = \"code\", reason = \"why\" }]` with `asset = \"name\"` for one light map, probe or gradient of the file alone",
                 [&](const auto& value) { readAllowances(value, scene); });
}

/// Reads a scene file with the keys of the command line over its own: a scene for each of its targets, in their order. Unknown keys are
/// refused with the nearest known one. Errors name file, line and column, or the option; found and expected.
formats::Result<std::vector<Scene>> readScenes(const std::filesystem::path& file, const GivenKeys& given = {});
/// Returns the first of them: for what does not depend on the target.
formats::Result<Scene> readScene(const std::filesystem::path& file, const GivenKeys& given = {});

/// Reads a scene that is no file: Scene::document, or one that a converter makes.
/// directory  that its paths are relative to
formats::Result<Scene> readSceneDocument(const Json& document, const std::filesystem::path& directory, const GivenKeys& given = {});

/// Returns what is wrong with the value that an option gives a key, "found ..., expected ...", or an empty text.
std::string faultOfKey(const std::string& key, const std::string& value);

/// Returns the tables of a scene file with their keys, for the reference.
std::span<const KeyTable> sceneKeyTables();

/// Returns the place of a table or key in the scene file, "scene.toml:7"; without a scene file `otherwise`.
formats::Subject placeIn(const Scene& scene, std::string_view section, std::string_view name, std::string_view key,
                         const std::string& otherwise);

}  // namespace lightcook::pipeline
