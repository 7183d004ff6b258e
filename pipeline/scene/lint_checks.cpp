#include "pipeline/scene/lint_checks.h"

#include <fmt/format.h>

#include <array>

#include "formats/vocabulary.h"

namespace lightcook::pipeline {
namespace {

using enum LintSeverity;

constexpr std::array kLintChecks = {
    LintCheckInfo{LintCheck::WrongPhase, "wrong-phase", Warning,
                  "light comes from behind the surface, and with the other sign convention it does not",
                  "Write `phase = \"condon-shortley\"` in the `[[light_map]]`, or `\"none\"` where it is already there."},
    LintCheckInfo{LintCheck::WrongFrame, "wrong-frame", Warning,
                  "light comes from behind the surface, and with coefficients of the other frame it does not",
                  "Write `frame = \"tangent\"` in the `[[light_map]]`, or `\"world\"` where `tangent` is there."},
    LintCheckInfo{LintCheck::WrongAxes, "wrong-axes", Warning,
                  "light comes from behind the surface, and with other axes it does not: the baker is Z up or left-handed",
                  "Write the `axes` that were found into the `[[light_map]]`. In a file with normals of its own, which the key turns too, "
                  "export coefficients and normals in the same axes."},
    LintCheckInfo{LintCheck::LitFromBehind, "lit-from-behind", Warning,
                  "light comes from behind the surface, under every sign convention, frame and choice of axes",
                  "Compare the coefficients and the normals of a few texels with those in the baker. If the bake gathers light over the "
                  "whole sphere, allow this code."},
    LintCheckInfo{LintCheck::WrongQuantity, "wrong-quantity", Warning,
                  "no light of one hemisphere has these ratios of SH bands, and with the other quantity it has",
                  "Write `quantity = \"irradiance\"` in the `[[light_map]]`, or `\"radiance\"` where `irradiance` is there."},
    LintCheckInfo{LintCheck::ImpossibleBands, "impossible-bands", Warning,
                  "no light of one hemisphere has these ratios of SH bands, under any reading of the file",
                  "Compare the order of the coefficients with `sh00` to `sh08`, and look for a window on the bands. If the bake gathers "
                  "light over the whole sphere, allow this code."},
    LintCheckInfo{
        LintCheck::ImpossibleDirections, "impossible-directions", Warning,
        "most of the map has more directed light than all of its light allows in the formula of its baker",
        "Look at the files of the directions: values near 0.5 say that light comes evenly from everywhere, and a white file is none. "
        "In channels of coefficients, compare their order with `sh00` to `sh08`."},
    LintCheckInfo{LintCheck::GammaCurve, "gamma-curve", Warning, "values look like they were stored under a gamma curve",
                  "Export linear values: no sRGB or 2.2 curve, and no tone mapping. lightcook does not undo the curve of an SH map."},
    LintCheckInfo{
        LintCheck::WrongPrimaries, "wrong-primaries", Warning,
        "the file states primaries (`chromaticities` of OpenEXR, `PRIMARIES` of Radiance) that are not those of `source` in `[color]`",
        "Write `source = \"stated\"` into `[color]`: each file is then converted from what it states. If all files are in one space, name "
        "that. "
        "If what the file states is wrong, allow this code."},
    LintCheckInfo{LintCheck::LightUnits, "light-units", Note,
                  "light map and probes of one scene differ in brightness by about pi, the factor between game units and radiometric units",
                  "Write `light_units = \"game\"` in the `[[light_map]]`, or `\"radiometric\"` where `game` is there."},
    LintCheckInfo{
        LintCheck::GroundTruthUnits, "ground-truth-units", Warning,
        "traced light (`ground_truth`) and its light map differ in brightness: their units, or their exposures",
        "Write `lambert` values as irradiance E, not E / pi, and all values in the units and the exposure of the light map after its "
        "`quantity` and `light_units`."},
    LintCheckInfo{
        LintCheck::NoCoverage, "no-coverage", Error, "no texel has coverage above 0.5: the map is empty",
        "Write 1 into coverage.Y, or alpha of a picture, inside charts and 0 outside, or leave the channel out of a map without gaps."},
    LintCheckInfo{LintCheck::CoverageRange, "coverage-range", Error, "coverage has values below 0 or above 1",
                  "Divide coverage.Y, or alpha of a picture, by its largest value, so that it is 1 inside charts and 0 outside."},
    LintCheckInfo{LintCheck::MissingCoverage, "missing-coverage", Note,
                  "the file has no channel coverage.Y, and it has gaps: texels without light or normal",
                  "Write coverage = \"mesh\" beside the map's mesh, or coverage = \"light\" if what is black is no surface; or "
                  "export coverage.Y, 1 inside charts and 0 outside. If the map has no gaps, allow this code."},
    LintCheckInfo{LintCheck::MissingNormals, "missing-normals", Note,
                  "neither the file nor a mesh has normals, so an engine's layout is fitted to surfaces that face +z",
                  "Write the map's mesh into `mesh`, or export normal.X/Y/Z, unit vectors in world space."},
    LintCheckInfo{LintCheck::IncompleteSet, "incomplete-set", Note,
                  "the name is that of one file of a set, the others are missing, and the file was read alone",
                  "Put the other files into its folder, or name what it is: `bake = \"flat\"`."},
    LintCheckInfo{LintCheck::ZeroNormals, "zero-normals", Error,
                  "the normal of every covered texel is zero or shorter than 1/2, so none counts as covered",
                  "Export unit normals in world space, or leave the channels normal.X/Y/Z out."},
    LintCheckInfo{LintCheck::SomeZeroNormals, "some-zero-normals", Warning,
                  "covered texels have a normal of zero or shorter than 1/2, and do not count as covered for it",
                  "Export unit normals wherever coverage.Y is 1."},
    LintCheckInfo{LintCheck::EncodedNormals, "encoded-normals", Error, "normals are stored as colours, (n + 1) / 2",
                  "Export the vectors themselves, from -1 to 1."},
    LintCheckInfo{LintCheck::NormalLength, "normal-length", Note, "normals are far from unit length, and their directions may be wrong",
                  "Export unit normals in world space: not filtered over edges, not scaled with the object."},
    LintCheckInfo{LintCheck::RimFirefly, "rim-firefly", Note, "a texel at the rim of a chart is far brighter than its neighbours",
                  "Bake with more samples, clamp the texel, or cook with a `firefly_limit` above the ratio if the light is real."},
    LintCheckInfo{LintCheck::BlackCharts, "black-charts", Note, "charts have no light at all",
                  "Look for objects that were left out of the bake, or whose backs face the light."},
    LintCheckInfo{
        LintCheck::Exposure, "exposure", Note,
        "the map or probe is so dark or so bright that half floats lose its light, and no screen shows it without a large exposure",
        "Is that its unit? Then set the exposure of the engine for it. Else scale the light of the bake, so that a lit surface has a "
        "radiance "
        "near 1."},
    LintCheckInfo{
        LintCheck::DisplayExposure, "display-exposure", Warning,
        "the display of the scene shows the map as black or beyond its brightest white, so no error of it is visible and every "
        "limit on visible errors holds",
        "Write the exit radiance that the game shows as diffuse white into `white` of `[display]`, not a luminance in cd/m^2, and "
        "its exposure compensation into `stops`; or leave both out."},
    LintCheckInfo{
        LintCheck::WrongMesh, "wrong-mesh", Warning,
        "mesh and light map do not fit: the mesh reads texels that no chart covers, or leaves charts of the map unread",
        "Write the mesh that was baked into `mesh`, all of it. TEXCOORD_1 is its light-map UV. `[[light_map.place]]` scales and moves "
        "the UVs of a node. If what the mesh lacks need not be shown, allow this code."},
    LintCheckInfo{LintCheck::FlippedV, "flipped-v", Warning, "mesh and light map do not fit, and with V upside down they do",
                  "Export the mesh with V pointing down, as glTF has it, or turn the rows of the light map over."},
    LintCheckInfo{
        LintCheck::NoLmbake, "no-lmbake", Warning,
        "Godot's lmbake is missing, so the UVs of a node are taken for places in the whole map, where they do not fit",
        "Put the lmbake of the bake beside it, or name it with `lmbake`. Of a bake that Godot split into several files, place the "
        "nodes with `[[light_map.place]]`: `lightcook info` lists their rectangles. If TEXCOORD_1 are UVs in the whole map "
        "already, write `lmbake = \"none\"`."},
    LintCheckInfo{LintCheck::NodesWithoutMap, "nodes-without-map", Warning,
                  "nodes with light-map UVs have a place in none of the light maps of their mesh, so no cooked mesh has them",
                  "Name them in a `[[light_map.place]]`, or allow this code if they are shown without a light map."},
    LintCheckInfo{LintCheck::UvOutside, "uv-outside", Warning, "light-map UVs lie outside [0, 1]",
                  "Unwrap the mesh again. A light map does not repeat."},
    LintCheckInfo{
        LintCheck::UvOverlap, "uv-overlap", Warning, "parts of the mesh share texels of the light map",
        "Unwrap the mesh again without overlaps: one texel cannot hold the light of two places. If nodes have light maps or rectangles "
        "of their own, say which with `[[light_map.place]]`."},
    LintCheckInfo{LintCheck::DrawnTwice, "drawn-twice", Warning,
                  "several nodes, or instances of one, draw one mesh, so that they show the same texels",
                  "Give each node a mesh of its own with light-map UVs of its own, or allow this code if their light is the same."},
    LintCheckInfo{LintCheck::UnplacedNodes, "unplaced-nodes", Error, "Godot's lmbake has no rectangle for nodes of the mesh",
                  "Leave what Godot did not bake out of the mesh, or bake it: a static mesh with UV2 and its name in the scene. Names and "
                  "parents of nodes are those of Godot's scene."},
    LintCheckInfo{
        LintCheck::UnreadRectangles, "unread-rectangles", Note,
        "rectangles of Godot's lmbake belong to no node of the mesh, so nothing shows their part of the map",
        "Export the whole scene that was baked, with the names that its nodes have in Godot. If the rest is a mesh of its own, allow "
        "this code. A node with several meshes (GridMap, MultiMesh) is not read."},
    LintCheckInfo{LintCheck::FlatTriangles, "flat-triangles", Error, "most of the light map lies on triangles without area in the world",
                  "Look for a scale of 0 in a node, and for vertices that were all put into one place."},
    LintCheckInfo{LintCheck::MeshNormals, "mesh-normals", Note, "vertices of the mesh have a normal of zero or shorter than 1/2",
                  "Compute the normals of the mesh again. Those of the triangles stand in for them. Triangles without area have none."},
    LintCheckInfo{LintCheck::UnknownMaterial, "unknown-material", Warning, "a `[[material]]` names no material of a mesh",
                  "Write the name that the glTF has. The entry changes what is cooked, but describes nothing in the scene."},
    LintCheckInfo{LintCheck::MaterialExtension, "material-extension", Note,
                  "a material has an extension that may change its reflection and that is not read",
                  "Write `m` and `f0` of the material as the engine shows it, or `specular = false`, into a `[[material]]`. If what is "
                  "assumed is right, allow this code."},
    LintCheckInfo{LintCheck::StaleBake, "stale-bake", Note, "the mesh is newer than its light map",
                  "Bake the light map again, or allow this code where file times mean nothing."},
    LintCheckInfo{LintCheck::EightBitProbe, "eight-bit-probe", Note,
                  "the probe has 8 bits a channel: light above 1 is lost, and its values may be under a gamma curve",
                  "Export the probe as EXR or Radiance HDR, linear and not clamped."},
    LintCheckInfo{LintCheck::ClippedProbe, "clipped-probe", Note, "the brightest light of the probe was cut at 1",
                  "Export the probe as EXR or Radiance HDR, linear and not clamped."},
    LintCheckInfo{LintCheck::BlackProbe, "black-probe", Note, "the probe has no light at all",
                  "Look for lights and objects that were left out of the bake."},
    LintCheckInfo{LintCheck::ProbeSh, "probe-sh", Note, "the image of a probe and its SH disagree",
                  "Check that `file` and `sh` are of the same probe and bake, the order and the axes of the faces, and the exposure."},
    LintCheckInfo{LintCheck::BlackGradient, "black-gradient", Note, "the gradient has no light at all",
                  "Look for a sky that was switched off, or for an image under another name."},
    LintCheckInfo{LintCheck::LimitAboveOne, "limit-above-one", Warning, "a limit of an error is above 1, which allows any result",
                  "Write a fraction: `max_error = 0.02` is 2 %."},
};
static_assert(formats::isCompleteTable(kLintChecks, LintCheck::LimitAboveOne));

}  // namespace

std::span<const LintCheckInfo> allLintChecks() {
    return kLintChecks;
}

const LintCheckInfo& info(LintCheck check) {
    return kLintChecks.at(static_cast<std::size_t>(check));
}

std::vector<std::string> EnumNames<LintCheck>::all() {
    return formats::namesOf(allLintChecks());
}

std::string lintCheckTable() {
    std::string table = "| code | | found | what to do |\n| --- | --- | --- | --- |\n";
    for (const LintCheckInfo& row : kLintChecks)
        table += fmt::format("| `{}` | {} | {} | {} |\n", row.name, enumNames<LintSeverity>()[static_cast<std::size_t>(row.severity)],
                             row.meaning, row.advice);
    return table;
}

}  // namespace lightcook::pipeline
