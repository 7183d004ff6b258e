// Steps of repack(): read the bake and find its charts (readInput), reduce each chart (reduceCharts), pack them (placeCharts), and write
// the new bake and the meshes with their new UVs (writeOutputs).
#include "pipeline/repack/repack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "atlas/charts.h"
#include "atlas/packing.h"
#include "atlas/reduction.h"
#include "formats/gltf_scene.h"
#include "formats/memory.h"
#include "formats/temporaries.h"
#include "lighting/radiometry.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/graph/file_list.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;

using formats::Error;
using formats::ErrorCode;
using formats::failure;
using formats::GltfScene;
using formats::Image;
using formats::Result;
using lighting::ShRgb;

/// Largest share of the texels that triangles read in charts without a covered texel: bakers leave out charts smaller than a texel.
constexpr double kMostDark = 0.005;

/// Texels of a light map in memory.
struct MapTexels {
    Image<ShRgb> sh;
    Image<std::uint8_t> covered;
    Image<glm::vec3> normal;
    formats::LightMapRepairs repairs = {};
    std::int64_t negativeAfterGamut = 0;

    explicit MapTexels(const glm::ivec2& size)
        : sh(size.x, size.y), covered(size.x, size.y, 0), normal(size.x, size.y, glm::vec3(0, 0, 1)) {}
    atlas::MapView view() const { return {sh.view(), covered.view(), normal.view()}; }
    static constexpr std::uint64_t kTexelBytes = sizeof(ShRgb) + sizeof(glm::vec3) + 1;
};

Result<MapTexels> readMap(LightMapSource& source, const fs::path& name, const RunState& state) {
    const std::uint64_t texels = static_cast<std::uint64_t>(source.width()) * static_cast<std::uint64_t>(source.height());
    // The bake, its charts and what is written are in memory together.
    LC_CHECK(formats::checkMemory(3 * MapTexels::kTexelBytes * texels, name));
    MapTexels map(glm::ivec2(source.width(), source.height()));
    for (int index = 0; index < source.chunkCount(); ++index) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, name, "interrupted");
        LC_TRY(chunk, source.chunk(index));
        const formats::LightMapStrip& strip = **chunk;
        map.repairs += strip.repairs;
        map.negativeAfterGamut += strip.negativeAfterGamut;
        for (int y = 0; y < strip.sh.height(); ++y) {
            std::copy_n(strip.sh.view().row(y), source.width(), map.sh.view().row(strip.firstRow + y));
            std::copy_n(strip.covered.view().row(y), source.width(), map.covered.view().row(strip.firstRow + y));
            std::copy_n(strip.normal.view().row(y), source.width(), map.normal.view().row(strip.firstRow + y));
        }
    }
    return map;
}

/// Returns the key of the display: that of exit radiance of the covered texels at their normals.
double keyOf(const MapTexels& map, const glm::vec3& luminanceWeights) {
    std::vector<double> luminances;
    for (std::size_t i = 0; i < map.sh.texels().size(); ++i) {
        if (map.covered.texels()[i] == 0) continue;
        const ShRgb exit = lighting::convolve(map.sh.texels()[i], lighting::kExitRadianceBands);
        luminances.push_back(static_cast<double>(glm::dot(lighting::evaluate(exit, map.normal.texels()[i]), luminanceWeights)));
    }
    return verify::displayKeyOf(luminances);
}

/// The glTF files, with the triangle meshes of all of them, in order.
struct Meshes {
    std::vector<GltfScene> scenes;
    std::vector<const formats::TriangleMesh*> triangles;
    std::vector<formats::Subject> names;  ///< "room.glb, primitive 2" for each of `triangles`
};

Result<Meshes> loadMeshes(const std::vector<fs::path>& files, const fs::path& lmbake, const std::vector<formats::NodePlace>& places) {
    Meshes meshes;
    for (const fs::path& file : files) {
        LC_TRY(scene, GltfScene::load(file, lmbake, places));
        if (const auto& match = scene->lmbakeMatch(); match && !match->unplaced.empty())
            return failure(ErrorCode::WrongShape, file,
                           fmt::format("found {}, expected all that Godot baked: leave the others out of the mesh",
                                       countOfNames(match->unplaced, "node(s) without a rectangle in " + lmbake.filename().string())));
        meshes.scenes.push_back(std::move(*scene));
        std::size_t primitive = 0;
        for (const formats::TriangleMesh* mesh : meshes.scenes.back().triangleMeshes()) {
            meshes.triangles.push_back(mesh);
            meshes.names.push_back(formats::Subject(file).at(fmt::format("primitive {}", primitive++)));
        }
    }
    if (meshes.triangles.empty()) return failure(ErrorCode::WrongShape, files.front(), "found no triangles, expected a mesh");
    return meshes;
}

/// The bake and its meshes, with the charts that the triangles make.
struct RepackInput {
    MapTexels map;
    Meshes meshes;
    atlas::ChartSet found;

    glm::ivec2 size() const { return {map.sh.width(), map.sh.height()}; }  ///< of the bake [texels]
};

Result<RepackInput> readInput(const RepackRequest& request, LightMapSource& source, const RunState& state) {
    LC_TRY(meshes, loadMeshes(request.meshes, request.lmbake, request.description.places));
    const glm::ivec2 size(source.width(), source.height());
    LC_TRY(found, atlas::findCharts(meshes->triangles, meshes->names, size.x, size.y));
    LC_TRY(map, readMap(source, request.map, state));
    return RepackInput{std::move(*map), std::move(*meshes), std::move(*found)};
}

/// Returns the place of the first triangle with an area in the world and none in the light map. Empty: there is none.
std::string flatTriangleOf(const Meshes& meshes) {
    for (std::size_t mesh = 0; mesh < meshes.triangles.size(); ++mesh) {
        const formats::TriangleMesh& triangles = *meshes.triangles[mesh];
        const formats::MeshAttribute *uv = triangles.find("TEXCOORD_1"), *position = triangles.find("POSITION");
        if (uv == nullptr || position == nullptr) continue;
        for (std::size_t i = 0; i + 2 < triangles.indices.size(); i += 3) {
            const auto sides = [&](const formats::MeshAttribute& attribute) {
                const glm::dvec3 corner(attribute.at(triangles.indices[i]));
                return glm::cross(glm::dvec3(attribute.at(triangles.indices[i + 1])) - corner,
                                  glm::dvec3(attribute.at(triangles.indices[i + 2])) - corner);
            };
            if (sides(*uv).z == 0 && sides(*position) != glm::dvec3(0))
                return meshes.names[mesh].at(fmt::format("triangle {}", i / 3)).text;
        }
    }
    return "";
}

/// Refuses meshes that do not belong to the bake: whose charts read no covered texel, or that leave too many covered texels unread.
/// charts  the reduced charts of the input
/// file    of the bake, for errors
Result<void> checkCoverage(const RepackInput& input, const std::vector<atlas::ReducedChart>& charts, const fs::path& file) {
    std::int64_t read = 0, dark = 0;
    std::size_t firstDark = charts.size();
    for (std::size_t i = 0; i < charts.size(); ++i) {
        bool isCovered = false;
        for (std::size_t texel = 0; texel < charts[i].covered.texels().size(); ++texel)
            isCovered = isCovered || (charts[i].isRead.texels()[texel] != 0 && charts[i].covered.texels()[texel] != 0);
        read += charts[i].readBefore;
        if (isCovered) continue;
        dark += charts[i].readBefore;
        firstDark = std::min(firstDark, i);
    }
    if (static_cast<double>(dark) > kMostDark * static_cast<double>(read)) {
        const atlas::Chart& chart = input.found.charts[firstDark];
        return failure(
            ErrorCode::WrongShape, input.meshes.names[chart.mesh].at(fmt::format("triangle {}", chart.triangle)),
            fmt::format("found no covered texel of {} in its chart, expected the mesh that was baked", file.filename().string()));
    }
    Image<std::uint8_t> unread = input.map.covered.copy();
    const glm::ivec2 last(unread.width() - 1, unread.height() - 1);
    for (const atlas::Chart& chart : input.found.charts)
        for (int y = 0; y < chart.quads.y; ++y)
            for (int x = 0; x < chart.quads.x; ++x)
                for (int corner = 0; chart.reaches(x, y) && corner < 4; ++corner) {
                    const glm::ivec2 at = glm::clamp(chart.first + glm::ivec2(x + corner % 2, y + corner / 2), glm::ivec2(0), last);
                    unread.at(at.x, at.y) = 0;
                }
    const auto covered = std::ranges::count(input.map.covered.texels(), std::uint8_t{1});
    const auto left = std::ranges::count(unread.texels(), std::uint8_t{1});
    if (static_cast<double>(left) <= kMostUnread * static_cast<double>(covered)) return {};
    const std::string flat = flatTriangleOf(input.meshes);
    return failure(ErrorCode::WrongShape, input.meshes.names.front(),
                   fmt::format("found {} of the {} covered texels of {} that no triangle reads, expected all meshes that use the bake{}",
                               left, covered, file.filename().string(),
                               flat.empty() ? "" : fmt::format("; {} has an area in the world and none in TEXCOORD_1", flat)));
}

/// A chart with its place in the new map.
struct PlacedChart {
    const atlas::Chart& chart;
    const atlas::ReducedChart& reduced;
    glm::ivec2 place;

    /// Returns the place in the new map of a place in the old one, both in texels.
    glm::dvec2 moved(const glm::dvec2& old) const {
        return (old - 0.5 - glm::dvec2(chart.first)) / glm::dvec2(reduced.step) + 0.5 + glm::dvec2(place);
    }
};

/// Returns the light-map UVs of the meshes in the new map.
/// size  of the new map [texels]
std::vector<std::vector<glm::vec2>> newUvs(const RepackInput& input, const std::vector<PlacedChart>& placed, const glm::dvec2& size) {
    std::vector<std::vector<glm::vec2>> uvs;
    const glm::dvec2 sizeBefore(input.size());
    for (std::size_t mesh = 0; mesh < input.meshes.triangles.size(); ++mesh) {
        const formats::MeshAttribute& uv = *input.meshes.triangles[mesh]->find("TEXCOORD_1");
        std::vector<glm::vec2>& made = uvs.emplace_back();
        for (std::size_t vertex = 0; vertex < input.found.ofVertex[mesh].size(); ++vertex) {
            const std::uint32_t chart = input.found.ofVertex[mesh][vertex];
            made.emplace_back(chart != atlas::ChartSet::kNoChart ? placed[chart].moved(glm::dvec2(uv.at(vertex)) * sizeBefore) / size
                                                                 : glm::dvec2(0));
        }
    }
    return uvs;
}

/// Writes the bake with the charts at their places.
Result<void> writeMap(const fs::path& file, const std::vector<PlacedChart>& placed, const glm::ivec2& size, const RunState& state) {
    MapTexels map(size);
    Image<std::uint32_t> charts(size.x, size.y, formats::kNoChart);
    std::uint32_t chart = formats::kAnyChart;
    for (const PlacedChart& each : placed) {
        ++chart;
        for (int y = 0; y < each.reduced.sh.height(); ++y)
            for (int x = 0; x < each.reduced.sh.width(); ++x) {
                if (each.reduced.isRead.at(x, y) == 0) continue;
                const glm::ivec2 to = each.place + glm::ivec2(x, y);
                // A chart that stays where it was may begin half a texel beyond the map, where samplers read its border.
                if (glm::clamp(to, glm::ivec2(0), size - 1) != to) continue;
                map.sh.at(to.x, to.y) = each.reduced.sh.at(x, y);
                map.covered.at(to.x, to.y) = each.reduced.covered.at(x, y);
                map.normal.at(to.x, to.y) = each.reduced.normal.at(x, y);
                charts.at(to.x, to.y) = chart;
            }
    }
    LC_TRY(writer, formats::LightMapWriter::create(file, size.x, size.y, formats::SurfaceOutput::CoverageNormalsAndCharts));
    const atlas::MapView view = map.view();
    for (int row = 0; row < size.y; row += kChunkRows) {
        if (state.interrupted) return failure(ErrorCode::Interrupted, file, "interrupted");
        const int rows = std::min(kChunkRows, size.y - row);
        const formats::SurfaceRows surface{view.covered.rows(row, rows), view.normal.rows(row, rows), charts.view().rows(row, rows)};
        LC_CHECK(writer->append(view.sh.rows(row, rows), surface));
    }
    return writer->commit();
}

/// The files to write, and those of earlier repacks in their folder.
struct RepackOutputs {
    std::vector<fs::path> files;       ///< the bake, then the meshes
    std::optional<FileNames> earlier;  ///< of the folder's list; empty: no list is kept, since nothing else lies in the folder
};

/// Returns the bake and the meshes that will be written. Refuses two of one name, and those that would replace an input.
Result<std::vector<fs::path>> filesToWrite(const RepackRequest& request) {
    std::vector<fs::path> inputs = {request.map}, outputs = {request.folder / request.map.filename().replace_extension(".exr")};
    for (const fs::path& mesh : request.meshes) {
        inputs.push_back(mesh);
        outputs.push_back(request.folder / mesh.filename().replace_extension(".glb"));
    }
    std::set<fs::path> names;
    for (const fs::path& output : outputs) {
        if (!names.insert(output).second)
            return failure(ErrorCode::InvalidRequest, output, "found two inputs of this name, expected different ones");
        for (const fs::path& input : inputs) {
            std::error_code code;
            if (fs::equivalent(input, output, code))
                return failure(ErrorCode::InvalidRequest, output, "found an input, expected a folder other than that of the inputs");
        }
    }
    return outputs;
}

/// Fails if a file would replace one that no earlier repack wrote. Returns the files that earlier ones wrote.
Result<FileNames> earlierOutputs(const std::vector<fs::path>& files, const fs::path& folder) {
    const fs::path list = folder / kRepackedListName;
    const auto earlier = readFileList(list);
    const auto isThere = [](const fs::path& file) {
        std::error_code code;
        return fs::exists(fs::symlink_status(file, code));
    };
    const auto refuse = [](const fs::path& file) {
        return failure(ErrorCode::InvalidRequest, file,
                       "found a file that no repack wrote, expected none of this name: move it, or give another folder to --output");
    };
    if (!earlier && isThere(list)) return refuse(list);
    for (const fs::path& file : files)
        if (isThere(file) && !(earlier && earlier->contains(file.filename().string()))) return refuse(file);
    return earlier.value_or(FileNames());
}

Result<RepackOutputs> outputsOf(const RepackRequest& request) {
    LC_TRY(files, filesToWrite(request));
    RepackOutputs outputs{std::move(*files), {}};
    if (!request.keepsOthers) return outputs;
    LC_TRY(earlier, earlierOutputs(outputs.files, request.folder));
    outputs.earlier = std::move(*earlier);
    return outputs;
}

/// Moves entries [begin, end) out.
template <class T>
std::vector<T> slice(std::vector<T>& all, std::size_t begin, std::size_t end) {
    return {std::make_move_iterator(all.begin() + static_cast<std::ptrdiff_t>(begin)),
            std::make_move_iterator(all.begin() + static_cast<std::ptrdiff_t>(end))};
}

Result<void> moveAll(const std::vector<fs::path>& outputs, const fs::path& from, const fs::path& folder) {
    LC_CHECK(makeFolder(folder));
    const auto transaction = formats::OutputTransaction::begin();  // an interrupt comes before or after all of them
    if (!transaction) return tl::make_unexpected(transaction.error());
    for (const fs::path& output : outputs) LC_CHECK(moveFile(from / output.filename(), output));
    return {};
}

/// Returns the number of compressed blocks of a map.
/// size  [texels]
std::int64_t blocksOf(const glm::ivec2& size) {
    constexpr int kBlock = 4;
    const glm::ivec2 blocks = (size + kBlock - 1) / kBlock;
    return std::int64_t{blocks.x} * blocks.y;
}

/// Returns the first texel of each chart in the bake.
std::vector<glm::ivec2> firstTexelsOf(const atlas::ChartSet& found) {
    std::vector<glm::ivec2> texels;
    for (const atlas::Chart& chart : found.charts) texels.push_back(chart.first);
    return texels;
}

/// Returns the limit on the error of reduced charts.
atlas::ReductionLimit limitOf(const RepackRequest& request, const MapTexels& map, const LightMapSource& source) {
    const glm::vec3 luminanceWeights = source.luminanceWeights();
    return {.maxVisible = request.maxVisible,
            .display = lighting::DisplaySettings{}.of(keyOf(map, luminanceWeights)),
            .bt2020FromWorking = source.bt2020FromWorking(),
            .luminanceWeights = luminanceWeights};
}

Result<std::vector<atlas::ReducedChart>> reduceCharts(const RepackInput& input, const atlas::ReductionLimit& limit,
                                                      const ActionContext& context) {
    const atlas::MapView view = input.map.view();
    const std::vector<atlas::Chart>& charts = input.found.charts;
    return mapInOrder<atlas::ReducedChart>(
        static_cast<int>(charts.size()), context, "repack " + context.action.asset, [&](int index) -> Result<atlas::ReducedChart> {
            return atlas::reduceChart(charts[static_cast<std::size_t>(index)], view, limit, context.state.interrupted);
        });
}

/// The charts of the new map.
struct ChartArrangement {
    glm::ivec2 size{0};  ///< of the map [texels]
    std::vector<atlas::ReducedChart> charts;
    std::vector<glm::ivec2> places;  ///< [chart] first texel
};

/// Packs reduced charts. They stay where they are, with all of their texels, if the map would take no fewer blocks otherwise.
/// limit  that the charts were reduced within
Result<ChartArrangement> placeCharts(const RepackInput& input, std::vector<atlas::ReducedChart> reduced, const atlas::ReductionLimit& limit,
                                     const ActionContext& context) {
    std::vector<formats::ImageView<const std::uint8_t>> isRead;
    for (const atlas::ReducedChart& chart : reduced) isRead.push_back(chart.isRead.view());
    auto packing = atlas::packCharts(isRead, context.state.interrupted);
    if (!packing) return tl::make_unexpected(interrupted(context).value());
    if (blocksOf(packing->size) < blocksOf(input.size()))
        return ChartArrangement{packing->size, std::move(reduced), std::move(packing->places)};
    if (std::ranges::any_of(reduced, [](const atlas::ReducedChart& chart) { return chart.step != glm::ivec2(1); })) {
        reduced.clear();  // before the others are in memory
        atlas::ReductionLimit none = limit;
        none.maxVisible = 0;
        LC_TRY(charts, reduceCharts(input, none, context));
        reduced = std::move(*charts);
    }
    return ChartArrangement{input.size(), std::move(reduced), firstTexelsOf(input.found)};
}

/// Returns the number of texels of the new map that filters read for a chart. A chart that stays where it is may reach half a texel beyond
/// the border, where samplers clamp.
std::int64_t readInside(const atlas::ReducedChart& chart, const glm::ivec2& place, const glm::ivec2& size) {
    std::int64_t count = 0;
    for (int y = std::max(0, -place.y); y < std::min(chart.isRead.height(), size.y - place.y); ++y)
        for (int x = std::max(0, -place.x); x < std::min(chart.isRead.width(), size.x - place.x); ++x) count += chart.isRead.at(x, y);
    return count;
}

/// Sets the places of the charts, and the sums and errors over all of them.
void addFigures(const ChartArrangement& arrangement, Repacked& result) {
    verify::VisibleAccumulator visible;
    double squaredError = 0, squaredLight = 0;
    for (std::size_t i = 0; i < arrangement.charts.size(); ++i) {
        const atlas::ReducedChart& chart = arrangement.charts[i];
        result.places.push_back({chart.step, arrangement.places[i]});
        visible.add(chart.visible);
        squaredError += chart.squaredError;
        squaredLight += chart.squaredLight;
        result.read += readInside(chart, arrangement.places[i], arrangement.size);
        result.readBefore += chart.readBefore;
        result.reducedCharts += chart.step != glm::ivec2(1) ? 1 : 0;
    }
    result.charts = arrangement.charts.size();
    result.visible = visible.figures();
    result.relRms = squaredLight > 0 ? std::sqrt(squaredError / squaredLight) : 0;
}

/// Writes the new bake and its meshes: all of them, or none.
Result<void> writeOutputs(const fs::path& folder, const RepackOutputs& outputs, const RepackInput& input,
                          const ChartArrangement& arrangement, const RunState& state) {
    std::vector<fs::path> files = outputs.files;
    LC_TRY(temporary, TemporaryFolder::create(folder));
    std::vector<PlacedChart> placed;
    for (std::size_t i = 0; i < arrangement.charts.size(); ++i)
        placed.push_back({input.found.charts[i], arrangement.charts[i], arrangement.places[i]});
    LC_CHECK(writeMap(*temporary / files.front().filename(), placed, arrangement.size, state));
    std::vector<std::vector<glm::vec2>> uvs = newUvs(input, placed, glm::dvec2(arrangement.size));
    std::size_t first = 0;
    for (std::size_t i = 0; i < input.meshes.scenes.size(); ++i) {
        const GltfScene& scene = input.meshes.scenes[i];
        const std::size_t end = first + scene.triangleMeshes().size();
        const fs::path file = *temporary / files[i + 1].filename();
        LC_TRY(done, scene.writeLightMapUvs(file, slice(uvs, first, end)));
        first = end;
    }
    if (outputs.earlier) {
        FileNames listed = *outputs.earlier;
        for (const fs::path& file : files) listed.insert(file.filename().string());
        files.push_back(folder / kRepackedListName);
        LC_CHECK(writeFile(*temporary / kRepackedListName, listText(listed)));
    }
    return moveAll(files, temporary->path(), folder);
}

}  // namespace

Result<Repacked> repack(const RepackRequest& request, const RunState& state, const Action* action) {
    LC_TRY(outputs, outputsOf(request));
    LightMapSources sources;
    LC_TRY(source, sources.open(request.map, request.description));
    LC_TRY(input, readInput(request, **source, state));

    SharedObjects shared;
    const Action own{"", "", request.map.filename().string(), {}, {}, {}};
    const ActionContext context{action != nullptr ? *action : own, {}, {}, {}, shared, state};
    const atlas::ReductionLimit limit = limitOf(request, input->map, **source);
    LC_TRY(reduced, reduceCharts(*input, limit, context));
    LC_CHECK(checkCoverage(*input, *reduced, request.map));
    LC_TRY(arrangement, placeCharts(*input, std::move(*reduced), limit, context));

    const std::vector<fs::path>& files = outputs->files;
    Repacked result{.map = files.front(),
                    .meshes = {files.begin() + 1, files.end()},
                    .sizeBefore = input->size(),
                    .size = arrangement->size,
                    .repairs = input->map.repairs,
                    .negativeAfterGamut = input->map.negativeAfterGamut,
                    .uvBefore = input->meshes.scenes.front().oldUvsAttribute()};
    addFigures(*arrangement, result);
    LC_CHECK(writeOutputs(request.folder, *outputs, *input, *arrangement, state));
    return result;
}

Json Repacked::toJson() const {
    Json json = {{"map", map.string()},
                 {"meshes", Json::array()},
                 {"width_before", sizeBefore.x},
                 {"height_before", sizeBefore.y},
                 {"width", size.x},
                 {"height", size.y},
                 {"texels_read_before", readBefore},
                 {"texels_read", read},
                 {"charts", charts},
                 {"reduced_charts", reducedCharts},
                 {"rel_rms", relRms},
                 {"visible",
                  {{"rms", visible.rms},
                   {"p50", visible.p50},
                   {"p95", visible.p95},
                   {"p99", visible.p99},
                   {"p999", visible.p999},
                   {"max", visible.max}}}};
    for (const fs::path& mesh : meshes) json["meshes"].push_back(mesh.string());
    return json;
}

}  // namespace lightcook::pipeline
