#include "pipeline/repack/chart_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <utility>

namespace lightcook::pipeline {
namespace {

using atlas::ChartSet;
using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Largest distance of a vertex from its place [texels]: UVs are floats.
constexpr double kUvRounding = 1.0 / 256;

/// Removes the entries of vertices that no kept triangle uses.
void keepVerticesOf(const formats::TriangleMesh& mesh, const std::vector<std::uint8_t>& isKept, std::vector<std::uint32_t>& ofVertex) {
    std::vector<std::uint8_t> isUsed(ofVertex.size(), 0);
    for (std::size_t corner = 0; corner < mesh.indices.size(); ++corner)
        if (isKept[corner / 3] != 0) isUsed[mesh.indices[corner]] = 1;
    std::size_t next = 0;
    for (std::size_t vertex = 0; vertex < isUsed.size(); ++vertex)
        if (isUsed[vertex] != 0) ofVertex[next++] = ofVertex[vertex];
    ofVertex.resize(next);
}

}  // namespace

Result<ChartPlaces> ChartPlaces::create(const formats::GltfScene& scene, const std::string& mesh, const UnpackedBake& bake) {
    const auto meshes = scene.triangleMeshes();
    const std::vector<std::string> names(meshes.size(), mesh);
    const glm::ivec2 before(bake.packing.widthBefore, bake.packing.heightBefore);
    auto charts = atlas::findCharts(meshes, names, before.x, before.y);
    if (!charts) return tl::make_unexpected(charts.error());
    const std::vector<ChartPlace> places = placesOf(bake.places);
    std::vector<std::optional<ChartPlace>> placed(charts->charts.size());
    std::vector<int> chosen;
    if (bake.part)
        chosen = bake.part->charts;
    else
        for (std::size_t i = 0; i < placed.size(); ++i) chosen.push_back(static_cast<int>(i));
    const bool isKnown = chosen.empty() || (chosen.front() >= 0 && chosen.back() < static_cast<int>(placed.size()));
    if (chosen.size() != places.size() || !std::ranges::is_sorted(chosen) || !isKnown)
        return failure(ErrorCode::Verification, mesh,
                       fmt::format("found {} charts, expected {} as packed: cook the scene again", placed.size(), places.size()));
    for (std::size_t i = 0; i < chosen.size(); ++i) placed[static_cast<std::size_t>(chosen[i])] = places[i];
    return ChartPlaces(std::move(*charts), std::move(placed), before);
}

ChartPlaces::ChartPlaces(ChartSet charts, std::vector<std::optional<ChartPlace>> places, const glm::ivec2& before)
    : charts_(std::move(charts)), places_(std::move(places)), before_(before), owners_(before.x + 1, before.y + 1, ChartSet::kNoChart) {
    for (std::size_t i = 0; i < charts_.charts.size(); ++i) {
        const atlas::Chart& chart = charts_.charts[i];
        for (int y = 0; y < chart.quads.y; ++y)
            for (int x = 0; x < chart.quads.x; ++x)
                if (chart.reaches(x, y)) owners_.at(chart.first.x + x + 1, chart.first.y + y + 1) = static_cast<std::uint32_t>(i);
    }
}

glm::dvec2 ChartPlaces::moved(std::size_t chart, const glm::dvec2& texel) const {
    const ChartPlace& place = *places_[chart];
    return (texel - glm::dvec2(charts_.charts[chart].first)) / glm::dvec2(place.step) + glm::dvec2(place.texel);
}

std::uint32_t ChartPlaces::ownerOf(const glm::ivec2& quad) const {
    const bool isInside = quad.x >= -1 && quad.y >= -1 && quad.x < before_.x && quad.y < before_.y;
    return isInside ? owners_.at(quad.x + 1, quad.y + 1) : ChartSet::kNoChart;
}

std::optional<glm::dvec2> ChartPlaces::packed(const glm::dvec2& texel) const {
    const std::uint32_t chart = chartAt(texel);
    if (chart == ChartSet::kNoChart || !places_[chart]) return std::nullopt;
    return moved(chart, texel);
}

std::uint32_t ChartPlaces::chartAt(const glm::dvec2& texel) const {
    // A place on a side of quads belongs to both: the chart of most of them has it, the first of equal ones.
    const glm::dvec2 floor = glm::floor(texel);
    const glm::ivec2 high(floor), low(high - glm::ivec2(texel.x == floor.x ? 1 : 0, texel.y == floor.y ? 1 : 0));
    std::array<std::uint32_t, 4> owners{};
    std::size_t count = 0;
    for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x)
            if (const std::uint32_t owner = ownerOf({x, y}); owner != ChartSet::kNoChart) owners[count++] = owner;
    if (count == 0) return ChartSet::kNoChart;
    const auto end = owners.begin() + static_cast<std::ptrdiff_t>(count);
    return *std::max_element(owners.begin(), end, [&](std::uint32_t a, std::uint32_t b) {
        return std::count(owners.begin(), end, a) < std::count(owners.begin(), end, b);
    });
}

Result<void> ChartPlaces::check(const formats::GltfScene& before, const formats::GltfScene& after, const std::string& mesh,
                                const glm::ivec2& size) const {
    const auto old = before.triangleMeshes(), made = after.triangleMeshes();
    const auto refuse = [&](const std::string& found, const std::string& expected) {
        return failure(ErrorCode::Verification, mesh, fmt::format("found {}, expected {}", found, expected));
    };
    std::vector<std::uint8_t> isPlaced;
    for (const auto& place : places_) isPlaced.push_back(place ? 1 : 0);
    const bool isWhole = std::ranges::count(isPlaced, 0) == 0;
    const std::vector<std::vector<std::uint8_t>> isKept = trianglesOfCharts(old, charts_, isPlaced);
    auto next = made.begin();
    for (std::size_t i = 0; i < old.size(); ++i) {
        std::vector<std::uint32_t> chartOf = charts_.ofVertex[i];
        if (!isWhole) keepVerticesOf(*old[i], isKept[i], chartOf);
        const formats::TriangleMesh from = isWhole ? *old[i] : formats::withTriangles(*old[i], isKept[i]);
        if (!isWhole && from.indices.empty()) continue;  // this part has nothing of the primitive
        if (next == made.end()) return refuse(fmt::format("{} primitives", made.size()), "more");
        const formats::TriangleMesh& to = **next++;
        const formats::MeshAttribute *uvBefore = from.find("TEXCOORD_1"), *uv = to.find("TEXCOORD_1");
        if (uv == nullptr || uv->vertexCount() != uvBefore->vertexCount() || from.indices != to.indices)
            return refuse(fmt::format("another primitive {}", i), "the vertices and triangles that it had");
        for (std::size_t vertex = 0; vertex < uv->vertexCount(); ++vertex) {
            const std::uint32_t chart = chartOf[vertex];
            if (chart == ChartSet::kNoChart) continue;
            const glm::dvec2 wanted = moved(chart, glm::dvec2(uvBefore->at(vertex)) * glm::dvec2(before_) - 0.5);
            const glm::dvec2 found = glm::dvec2(uv->at(vertex)) * glm::dvec2(size) - 0.5;
            const glm::dvec2 off = glm::abs(found - wanted);
            if (off.x <= kUvRounding && off.y <= kUvRounding) continue;
            return refuse(fmt::format("vertex {} of primitive {} at texel ({:.3f}, {:.3f})", vertex, i, found.x, found.y),
                          fmt::format("({:.3f}, {:.3f}), where its chart was packed", wanted.x, wanted.y));
        }
    }
    if (next != made.end()) return refuse(fmt::format("{} primitives", made.size()), fmt::format("{}", next - made.begin()));
    return {};
}

std::vector<std::vector<std::uint8_t>> trianglesOfCharts(std::span<const formats::TriangleMesh* const> meshes, const ChartSet& charts,
                                                         const std::vector<std::uint8_t>& isChosen) {
    std::vector<std::vector<std::uint8_t>> triangles;
    for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh) {
        std::vector<std::uint8_t>& isKept = triangles.emplace_back();
        for (std::size_t corner = 0; corner < meshes[mesh]->indices.size(); corner += 3)
            isKept.push_back(isChosen[charts.ofVertex[mesh][meshes[mesh]->indices[corner]]]);
    }
    return triangles;
}

std::vector<int> numbersOf(std::span<const ChartPlace> places) {
    std::vector<int> numbers;
    for (const ChartPlace& place : places) numbers.insert(numbers.end(), {place.step.x, place.step.y, place.texel.x, place.texel.y});
    return numbers;
}

std::vector<ChartPlace> placesOf(std::span<const int> numbers) {
    std::vector<ChartPlace> places;
    for (std::size_t i = 0; i + 3 < numbers.size(); i += 4)
        places.push_back({{std::max(1, numbers[i]), std::max(1, numbers[i + 1])}, {numbers[i + 2], numbers[i + 3]}});
    return places;
}

}  // namespace lightcook::pipeline
