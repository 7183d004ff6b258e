#include "pipeline/scene/keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "formats/bake_format.h"
#include "formats/light_map_conventions.h"
#include "formats/lmbake.h"
#include "formats/target.h"
#include "formats/vocabulary.h"
#include "pipeline/scene/chart_mode.h"
#include "pipeline/scene/checks.h"
#include "pipeline/scene/cubemap_layout.h"
#include "pipeline/scene/dominant_fit.h"
#include "pipeline/scene/dominant_layout.h"
#include "pipeline/scene/rsrm_format.h"
#include "pipeline/scene/scene.h"
#include "pipeline/scene/up_axis.h"

namespace lightcook::pipeline {
namespace {

/// Returns the names in quotes and code marks: `"a"`, `"b"`.
std::string choices(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += fmt::format("{}`\"{}\"`", text.empty() ? "" : ", ", name);
    return text;
}

template <class Row>
std::string choices(std::span<const Row> rows) {
    return choices(formats::namesOf(rows));
}

std::string inCode(std::string_view name) {
    return fmt::format("`\"{}\"`", name);
}

/// Returns "`none`: no Condon-Shortley signs; ..." for the rows of a table.
template <class Row>
std::string captions(std::span<const Row> rows) {
    std::string text;
    for (const Row& row : rows) text += fmt::format("{}`{}`: {}", text.empty() ? "" : "; ", row.name, row.caption);
    return text;
}

/// Returns a key whose values are the rows of a table, the default first.
template <class Row>
SceneKeyInfo enumeratedKey(std::string_view name, std::span<const Row> rows, std::string_view what) {
    return {name, choices(rows), inCode(rows.front().name), fmt::format("{}. {}", what, captions(rows))};
}
template <class Enum>
SceneKeyInfo conventionKey(std::string_view name, std::string_view what) {
    return enumeratedKey(name, formats::conventions<Enum>(), what);
}

constexpr const char* kBoolean = "true, false";

SceneSectionInfo rootSection() {
    return {
        .name = "",
        .isArray = false,
        .intro = "",
        .keys =
            {{"schema", "integer", "required", "`1`: the version of this format"},
             {"name", "string", "required", "name of the scene, in manifest and report"},
             {"allow", "list", "none",
              "warnings of [lint](../guide/lint.md) that are right as they are: `[\"code\"]`, or "
              "`[{ code = \"code\", reason = \"why\" }]` with `asset = \"name\"` for one light map, probe or gradient of the file alone"},
             {"lobe", choices(formats::sceneLobes()), inCode(formats::sceneLobes().front().name),
              "[specular lobe](../theory/lighting.md#specular-tables) of cubemaps, tables, dominant lights, shader and verification: "
              "that of the engine's materials"},
             enumeratedKey("up_axis", allUpAxes(),
                           "axis of world space that points up: that of painted gradients. It is for the manifest and the camera of "
                           "`view`; nothing is turned")},
        .outro = ""};
}

SceneSectionInfo outputSection() {
    return {
        .name = "output",
        .isArray = false,
        .intro = "",
        .keys =
            {{"target", choices(formats::allTargets()), inCode(formats::allTargets().front().name), "family of GPU formats"},
             {"max_error", "fraction", "none; of meshes 0.1",
              "`0.02` or `\"2%\"`: limit on `rel_rms` of diffuse and of specular light, of light maps and meshes; above it verification "
              "fails (exit code 4), and a limit below what the bake itself loses is refused [at once](../theory/error.md#floor)"},
             {"max_converter_error", "fraction", "0.1, of cubemaps 0.5, or `max_error` if that is larger",
              "limit of dominant lights, cubemaps, tables and reflection maps, each on its own quantity"},
             {"max_visible", "number",
              "5 where the layout is `\"auto\"` and none of `max_error`, `max_visible_bound`, `max_whole_visible`, `max_whole_error` and "
              "`budget` is given, else none. The default chooses the layout; where none keeps it, the best one passes",
              "limit on the [visible error](../theory/visible.md) of light maps and meshes, in just noticeable differences: 99 % of the "
              "samples are within it; above it verification fails (exit code 4)"},
             {"max_visible_bound", "number", "none",
              "limit on the [proven bound](../theory/bounds.md#visible-errors) of the visible error of light maps and meshes, in just "
              "noticeable "
              "differences: no place, normal or view is above it; else verification fails (exit code 4)"},
             {"max_seam", "number", "none",
              "limit on the [seams](../theory/visible.md#seams) that cooking adds where charts of a light map meet on its mesh, also "
              "between maps of `charts = \"split\"`, in just noticeable differences; above it verification fails (exit code 4)"},
             {"max_whole_visible", "number", "none",
              "limit on the visible error (p99) of what a pixel shows of a light map and its dominant light together. Their layouts are "
              "chosen together, [the smallest within it](../guide/memory-budgets.md#a-limit-in-place-of-a-budget); above it verification "
              "fails (exit code 4)"},
             {"max_whole_error", "fraction", "none", "the same limit on `rel_rms` of what a pixel shows of them together"},
             {"max_converter_visible", "number", "none",
              "the same limit of dominant lights, cubemaps, tables and reflection maps, each in the "
              "[light that it adds to a pixel](../theory/visible.md#other-assets)"},
             {"max_converter_visible_bound", "number", "none",
              "limit on the proven bound of dominant lights, cubemaps, tables and reflection maps. That of a dominant light is always "
              "[the largest difference of the display](../theory/bounds.md#the-largest-difference-of-a-display)"},
             {"budget", "size", "none",
              "GPU memory of the whole scene: `\"2 MiB\"`, `\"1.5 GB\"`, `\"4096\"` (bytes); more is exit code 5"},
             {"light_map_layout", choices(lightMapLayoutChoices()), "`\"auto\"`", "see [layouts](../theory/layouts.md)"},
             enumeratedKey("cost", formats::allLayoutCosts(),
                           "what `auto` keeps small where an error limits it; [light-map layouts](light-map-layouts.md) has the costs"),
             {"max_fetches", "integer", "none", "limit on the texture fetches of a light map's sample: `auto` takes no other layout"},
             {"max_decode_ops", "integer", "none", "limit on the multiply-adds of its decode, likewise"},
             {"layouts", "list", "none: those that a trial measures",
              "layouts that `auto` may take, which the engine reads: `[\"godot\", \"sh4\"]`. No other one stands in for them, not even a "
              "smaller one for bands that no shading shows. [From the trial](../guide/into-an-engine.md#layouts-that-the-engine-reads) the "
              "report says "
              "what the list costs"},
             enumeratedKey("objective", formats::allObjectives(), "what learned layouts of light maps and ratio minimize"),
             {"container", choices({"ktx2", "dds"}), "`\"ktx2\"`", "container of the textures"},
             {"zstd", kBoolean, "false", "Zstandard supercompression of KTX2 levels"},
             {"effort", "0 to 9", "5",
              "effort of the block encoders: 0 is fastest, 9 best. Not beside target `float`, whose texels are not encoded"},
             {"rdo", "0 to 1", "0",
              "target `bc`: share by which the error of a row of blocks may grow, for smaller files with `zstd` "
              "([encoding textures](../guide/encoding-textures.md#rate-distortion-optimization))"},
             {"draco", kBoolean, "true",
              "write meshes as Draco inside glTF, with the fewest bits that the limit allows "
              "([meshes](../guide/into-an-engine.md#meshes)). `false`: a mesh is written only under a learned layout, unchanged except for "
              "the added attribute"},
             enumeratedKey(
                 "charts", allChartModes(),
                 "[charts](../guide/memory-budgets.md#fewer-texels) of the light maps. Every mode but `\"keep\"` needs their meshes"),
             {"charts_max_visible", "number from 0 to 100", "0",
              "`charts = \"pack\"` or `\"split\"`: visible error that fewer texels may add to 99 % of a chart's samples, in just "
              "noticeable differences. "
              "0: charts are moved only, without loss"},
             {"gltf", kBoolean, "false",
              "also write each light map with its mesh as glTF, with the light map bound "
              "([glTF](../guide/into-an-engine.md#the-scene-as-gltf)); as `cook --gltf`"},
             {"mips", kBoolean, "false",
              "write the light maps with mip levels, from level 0 to the last that keeps their charts apart "
              "([mip levels](../guide/into-an-engine.md#mip-levels)); the limits on the error hold for each level. As `cook --mips`"},
             {"keep_unused", kBoolean, "false",
              "cook also what the report would list as skipped for its content: each texel of a map of constant light, bands that no "
              "shading shows, probes that no surface uses, rows of reflection maps that no material reads"}},
        .outro = ""};
}

SceneSectionInfo colorSection() {
    return {.name = "color",
            .isArray = false,
            .intro = "",
            .keys = {{"source", "string", "`\"lin_rec709\"`",
                      "colour space of the files; `\"stated\"`: for each file what it states (`chromaticities` of OpenEXR, `PRIMARIES` of "
                      "Radiance), else "
                      "lin_rec709"},
                     {"working", "string", "`\"lin_rec709\"`", "colour space of the engine"},
                     {"config", "path", "built in", "OpenColorIO configuration that has both"}},
            .outro = "[Colour](../theory/lighting.md#colour) lists the built-in spaces. Conversions that are not linear are refused."};
}

SceneSectionInfo displaySection() {
    return {.name = "display",
            .isArray = false,
            .intro = "",
            .keys = {{"white", "number from 1e-9 to 1e9", "none: the key of each light map is shown at 18 % of diffuse white",
                      "exit radiance that the game shows as diffuse white, 203 cd/m^2"},
                     {"stops", "number from -20 to 20", "0", "exposure compensation: light is shown 2^stops as bright"},
                     {"black", "number from 0.005 to 100", "0.5", "luminance of the display's black in its room, in cd/m^2"}},
            .outro = "How the game shows the scene: [visible errors](../theory/visible.md) are judged there."};
}

SceneSectionInfo lightMapSection() {
    std::string bakes =
        fmt::format("format of the file. `{}`: by its channels, its name, its size and the files beside it", formats::kAutoBake);
    for (const formats::BakeFormatInfo& row : formats::allBakeFormats()) bakes += fmt::format("; `{}`: {}", row.name, row.caption);
    return {
        .name = "light_map",
        .isArray = true,
        .intro = "",
        .keys =
            {{"name", "string", "required",
              "name of the asset and its files: up to 128 letters, digits, `_`, `-` and `.`. Names of light maps, probes and gradients "
              "differ "
              "in more than the case of letters"},
             {"file", "path", "required, or `files`",
              "EXR, tiled or scan-line, half or float; or Radiance HDR; or an 8-bit picture with an `encoding`; or a glTF of Unreal. Of a "
              "bake of several files any one of them: the others are found beside it"},
             {"files", "table of paths", "none",
              "in place of `file`: one image for each coefficient, `{ sh00 = \"a.exr\", sh01 = \"b.exr\", ... }` to `sh03` or `sh08`, or "
              "one "
              "for each colour, `{ sh00 = { R = \"r.exr\", G = \"g.exr\", B = \"b.exr\" }, ... }`. The first may have the channels of "
              "coverage and normal"},
             {"bake", choices(formats::bakeNames()), inCode(formats::kAutoBake), bakes},
             {"layout", "as `bake`", "none", "older name of `bake`; not beside it"},
             conventionKey<formats::ShPhase>("phase", "sign convention"),
             conventionKey<formats::ShFrame>("frame", "axes of the coefficients"),
             {"axes", "three of `x`, `y`, `z`, each with or without `-`", inCode(formats::BakeAxes().name()),
              "components of the file's vectors that are x, y and z of the mesh: `\"-x,y,z\"` for Unity, `\"x,z,-y\"` for a baker that is "
              "Z "
              "up. Turns coefficients, directions and normals of the file; of `frame = \"tangent\"`, the normals that the frames are of. "
              "It "
              "brings the bake into the world of the mesh; `up_axis` says which axis of that world points up, and neither changes the "
              "other"},
             conventionKey<formats::ShQuantity>("quantity", "quantity that the coefficients expand"),
             conventionKey<formats::LightUnits>("light_units", "units of the bake's light sources"),
             conventionKey<formats::LightEncoding>(
                 "encoding", fmt::format("encoding of the colours of a picture of 8 or 16 bits (PNG, TGA, TIFF), for the bake formats {}",
                                         fmt::join(formats::encodedBakeNames(), ", "))),
             conventionKey<formats::CoverageSource>("coverage", "what says which texels lie inside charts"),
             {"image", "string", "none",
              fmt::format("name or index of the image of a glTF that has light maps in several, for bake format {}",
                          fmt::join(formats::gltfBakeNames(), ", "))},
             {"firefly_limit", "number from 1, or 0", "1000",
              "largest ratio of a texel to its brightest neighbour; above it the texel is a firefly. 0: no test (charts of one texel are "
              "never tested)"},
             {"dominant_fit", choices(allDominantFits()), inCode(allDominantFits().front().name),
              fmt::format("method of the [dominant light](../theory/lighting.md#dominant-light). {}. `\"closed\"` is an older name of "
                          "`\"halo3\"`",
                          captions(allDominantFits()))},
             {"dominant_layout", choices(allDominantLayouts()), "none; see right",
              fmt::format(
                  "size and number of the textures of the dominant light. {}. Absent: `\"full\"`, or with a `budget` what the budget "
                  "buys",
                  captions(allDominantLayouts()))},
             {"max_visible", "number", "that of `[output]`", "limit on the visible error of this light map, and of its mesh"},
             {"max_visible_bound", "number", "that of `[output]`",
              "limit on the proven bound of the visible error of this light map, and of its mesh"},
             {"layouts", "list", "those of `[output]`", "layouts that `auto` may take for this light map"},
             {"charts", choices(allChartModes()), "that of `[output]`", "what happens to the charts of this light map"},
             {"charts_max_visible", "number from 0 to 100", "that of `[output]`",
              "visible error that fewer texels of its packed charts may add"},
             {"max_seam", "number", "that of `[output]`", "limit on the added seams of this light map; it needs a `mesh`"},
             {"mips", kBoolean, "that of `[output]`", "write this light map with mip levels"},
             {"ground_truth", "path", "none",
              "CSV of light traced at texels of the map, to separate truncation, fit and quantization "
              "([format](../theory/error.md#ground-truth))"},
             {"mesh", "path", "none",
              fmt::format(
                  "glTF or GLB whose `TEXCOORD_1` is the light-map UV. Its materials decide what the scene needs. A learned layout keeps "
                  "each of its islands under one basis ([clusters](../theory/layouts.md#clusters-in-the-mesh)). Bake formats {} are "
                  "relative to its surfaces and need it",
                  fmt::join(formats::meshBakeNames(), ", "))},
             {"lmbake", fmt::format("path, or `\"{}\"`", formats::kNoLmbake), "the file beside the bake with the extension `.lmbake`",
              fmt::format("of a bake of Godot ({}): the file that says which rectangle of the map each node of the `mesh` has. "
                          "`\"{}\"`: `TEXCOORD_1` are UVs in the whole map already",
                          fmt::join(formats::lmbakeBakeNames(), ", "), formats::kNoLmbake)},
             {"place", "tables", "none: the map lies on all nodes",
              "nodes of the `mesh` that the map lies on, each in a table `[[light_map.place]]`"}},
        .outro =
            "[From a baker to a scene](../guide/from-a-baker-to-a-scene.md#light-maps) lists the values that are refused, and "
            "`--repair`."};
}

SceneSectionInfo placeSection() {
    return {
        .name = "light_map.place",
        .isArray = true,
        .intro =
            "A node of the mesh that the light map above lies on. Nodes without a place are not of this map, and its cooked mesh leaves "
            "them out: one glTF may have a light map for each of its nodes, or rectangles of one map.",
        .keys = {{"node", "string", "required",
                  "name of a node, or the end of its path as in `\"Room/Wall\"`. Nodes below it count too, unless they have a place of "
                  "their own"},
                 {"scale", "two numbers", "[1, 1]", "factors of the node's light-map UVs"},
                 {"offset", "two numbers", "[0, 0]", "what is added to them then: UVs in the map are `uv * scale + offset`, with v down"}},
        .outro =
            "[From a baker to a scene](../guide/from-a-baker-to-a-scene.md#one-mesh-several-light-maps) says what Unity, bevy and "
            "other bakers call these."};
}

SceneSectionInfo tablesSection() {
    return {.name = "tables",
            .isArray = false,
            .intro = "Specular tables, made where a material is specular. `lightcook lut` has the same options.",
            .keys = {{"views", fmt::format("2 to {}", kMostTableNodes),
                      fmt::format("{1}; with `budget` {1} where the layouts leave room, else {0}", kLeastViewCount, kFineViewCount),
                      "columns: views"},
                     {"rows", fmt::format("1 to {}", kMostTableNodes), "those of 16, m 1/16 to 1, that the materials need",
                      "rows, spread over exactly the materials' range of m"},
                     {"lobe", choices(formats::sceneLobes()), "the scene's `lobe`",
                      "older place of the scene's `lobe`; refused if the two differ. `distribution` in the manifest"},
                     {"normalization", choices(kNormalizationNames), inCode(kNormalizationNames.front()),
                      "`halo3`: four times as bright; not for Phong lobes"},
                     {"view_axis", choices(viewAxisNames()), "`\"auto\"`",
                      "quantity along columns; `auto`: the one with the least interpolation error"},
                     {"roughness_axis", choices(roughnessAxisNames()), "`\"auto\"`", "quantity along rows"},
                     {"max_visible", "number", "`max_converter_visible` of `[output]`", "limit on the visible error of the tables"},
                     {"max_visible_bound", "number", "`max_converter_visible_bound` of `[output]`",
                      "limit on the proven bound of the visible error of the tables"}},
            .outro = ""};
}

SceneSectionInfo probeSection() {
    return {.name = "probe",
            .isArray = true,
            .intro = "",
            .keys = {{"name", "string", "required", "name of the asset"},
                     {"file", "path", "required",
                      "equirectangular panorama, or six faces as a strip, a cross or six files "
                      "([shapes](../guide/from-a-baker-to-a-scene.md#probes)); EXR or Radiance HDR"},
                     {"sh", "path", "projected from the image",
                      "JSON with the probe's own SH, found by the image's file name: "
                      "`{\"probes\": [{\"file\": \"...\", \"sh\": [[r, g, b], ... nine]}]}`"},
                     {"size", fmt::format("a power of two, {} to {}, or `\"{}\"`", kLeastProbeSize, kMostProbeSize, kAutoProbeSize),
                      fmt::format("`\"{}\"`", kAutoProbeSize),
                      fmt::format("texels along the edge of a face. The levels go down to one texel a face. `\"{}\"`: the levels of {} "
                                  "less the largest ones, if the materials are too rough to read them",
                                  kAutoProbeSize, ProbeEntry{}.size)},
                     enumeratedKey("layout", allCubemapLayouts(), "what a texel holds"),
                     {"position", "`[x, y, z]`", "that of the file `sh`", "world place of the probe, for the manifest"},
                     {"box", "six numbers", "that of the file `sh`",
                      "room that an engine corrects reflections for: lowest corner, then highest corner. In the JSON `[[x, y, z], [X, Y, "
                      "Z]]`"},
                     {"radius", "number", "that of the file `sh`", "radius of the sphere that the probe lights"},
                     {"max_visible", "number", "`max_converter_visible` of `[output]`", "limit on the visible error of this cubemap"},
                     {"max_visible_bound", "number", "`max_converter_visible_bound` of `[output]`",
                      "limit on the proven bound of the visible error of this cubemap"}},
            .outro = ""};
}

SceneSectionInfo gradientSection() {
    return {
        .name = "gradient",
        .isArray = true,
        .intro = "",
        .keys = {{"name", "string", "required", "name of the asset"},
                 {"file", "path", "required",
                  "painted: N x 1 texels of equal solid angle, from the axis (north) to its opposite, HDR or 8 bits; or, with `axis`, an "
                  "environment as a probe's"},
                 {"exponents", "numbers, 1 to 65536", fmt::format("`[{}]`", fmt::join(GradientEntry{}.exponents, ", ")),
                  "Phong exponents, one row each; 1 is Lambert exit radiance"},
                 {"encoding", choices(kGradientEncodings), inCode(kGradientEncodings.front()),
                  "of painted gradients. `auto`: the sRGB curve for PNG, JPEG, TGA and BMP, linear for others. The primaries are those "
                  "of `color.source` either way"},
                 {"axis", "`[x, y, z]`", "none",
                  "the file is an environment, averaged around this world direction "
                  "([loss](../theory/lighting.md#radially-symmetric-reflection-maps))"},
                 {"zones", fmt::format("1 to {}", kMostGradientZones), "256", "with `axis`: number of zones of equal solid angle"},
                 {"format", choices(rsrmFormatChoices()),
                  fmt::format("`\"{}\"` where it keeps the error limit, else `\"{}\"`", info(RsrmFormat::Rgba8).name, kAutoRsrmFormat),
                  fmt::format(
                      "{}. `{}`: the smallest format of the target that keeps `max_converter_error`, both as `rel_rms` and as `p99` "
                      "at texel centres. `bc7`, `bc4` and `bc6h` are for target `bc` alone; their rows count in fours. "
                      "[Which one](../theory/lighting.md#radially-symmetric-reflection-maps) holds a sun",
                      captions(allRsrmFormats()), kAutoRsrmFormat)},
                 {"dither", kBoolean, "false",
                  "`rgba8`: rounding errors are carried to the next texel of the row, so that slow gradients have no bands"},
                 {"max_visible", "number", "`max_converter_visible` of `[output]`", "limit on the visible error of this reflection map"},
                 {"max_visible_bound", "number", "`max_converter_visible_bound` of `[output]`",
                  "limit on the proven bound of the visible error of this reflection map"}},
        .outro = ""};
}

SceneSectionInfo materialSection() {
    return {.name = "material",
            .isArray = true,
            .intro = "Adds to the glTF's materials, or overrides them.",
            .keys = {{"name", "string", "required", "name of a material in the glTF, once in the file; `\"*\"` is every material"},
                     {"normal_map", kBoolean, "from the glTF", "false and no specular: a flat map is enough"},
                     {"normal_map_tilt", "number from 1 to 90", "60",
                      "largest angle between a normal of the normal map and that of the surface [degrees]. Visible errors are measured and "
                      "bounded up to the largest angle of all materials"},
                     {"specular", kBoolean, "from the glTF", "false: no dominant light, no tables, no cubemaps"},
                     {"m", "two numbers in [0, 1]", "from the glTF",
                      "the range of roughness: m of Beckmann, alpha of GGX (glTF: `roughnessFactor` squared)"},
                     {"f0", "two numbers in [0, 1]", "from the glTF", "the range of reflectance at normal incidence"}},
            .outro = ""};
}

}  // namespace

std::span<const SceneSectionInfo> allSceneSections() {
    static const std::vector<SceneSectionInfo> sections = {rootSection(),     outputSection(),  colorSection(),  displaySection(),
                                                           lightMapSection(), placeSection(),   tablesSection(), probeSection(),
                                                           gradientSection(), materialSection()};
    return sections;
}

const SceneSectionInfo& sceneSection(std::string_view name) {
    const auto sections = allSceneSections();
    const auto found =
        std::find_if(sections.begin(), sections.end(), [&](const SceneSectionInfo& section) { return section.name == name; });
    if (found == sections.end()) throw std::logic_error(fmt::format("no section '{}' in the scene file", name));
    return *found;
}

}  // namespace lightcook::pipeline
