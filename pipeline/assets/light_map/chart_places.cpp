#include "pipeline/assets/light_map/chart_places.h"

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

}  // namespace

Result<ChartPlaces> ChartPlaces::create(const formats::GltfScene& scene, const formats::Subject& mesh, const UnpackedBake& bake) {
    const glm::ivec2 before(bake.packing.widthBefore, bake.packing.heightBefore);
    const auto meshes = scene.triangleMeshes();
    LC_TRY(charts, atlas::findCharts(meshes, std::vector<formats::Subject>(meshes.size(), mesh), before.x, before.y));
    std::vector<ChartPlace> places = placesOf(bake.places);
    if (charts->charts.size() != places.size())
        return failure(ErrorCode::Verification, mesh,
                       fmt::format("found {} charts, expected {} as packed: cook the scene again", charts->charts.size(), places.size()));
    return ChartPlaces(std::move(*charts), std::move(places), before);
}

ChartPlaces::ChartPlaces(ChartSet charts, std::vector<ChartPlace> places, const glm::ivec2& before)
    : charts_(std::move(charts)), places_(std::move(places)), before_(before), owners_(before.x + 1, before.y + 1, ChartSet::kNoChart) {
    for (std::size_t i = 0; i < charts_.charts.size(); ++i) {
        const atlas::Chart& chart = charts_.charts[i];
        for (int y = 0; y < chart.quads.y; ++y)
            for (int x = 0; x < chart.quads.x; ++x)
                if (chart.reaches(x, y)) owners_.at(chart.first.x + x + 1, chart.first.y + y + 1) = static_cast<std::uint32_t>(i);
    }
}

glm::dvec2 ChartPlaces::moved(std::size_t chart, const glm::dvec2& texel) const {
    const ChartPlace& place = places_[chart];
    return (texel - glm::dvec2(charts_.charts[chart].first)) / glm::dvec2(place.step) + glm::dvec2(place.texel);
}

std::optional<glm::dvec2> ChartPlaces::packed(const glm::dvec2& texel) const {
    const std::uint32_t chart = chartAt(texel);
    if (chart == ChartSet::kNoChart) return std::nullopt;
    return moved(chart, texel);
}

std::uint32_t ChartPlaces::chartAt(const glm::dvec2& texel) const {
    // A place lies in one quad, or on the sides of up to four. It has the chart of most of them, the first of equal ones.
    const glm::dvec2 floor = glm::floor(texel);
    const glm::ivec2 high(floor), low(high - glm::ivec2(texel.x == floor.x ? 1 : 0, texel.y == floor.y ? 1 : 0));
    std::array<std::uint32_t, 4> owners{};
    std::size_t count = 0;
    for (int y = std::max(low.y, -1); y <= std::min(high.y, before_.y - 1); ++y)
        for (int x = std::max(low.x, -1); x <= std::min(high.x, before_.x - 1); ++x)
            if (const std::uint32_t owner = owners_.at(x + 1, y + 1); owner != ChartSet::kNoChart) owners[count++] = owner;
    if (count == 0) return ChartSet::kNoChart;
    const auto end = owners.begin() + static_cast<std::ptrdiff_t>(count);
    return *std::max_element(owners.begin(), end, [&](std::uint32_t a, std::uint32_t b) {
        return std::count(owners.begin(), end, a) < std::count(owners.begin(), end, b);
    });
}

Result<void> ChartPlaces::check(const formats::GltfScene& before, const formats::GltfScene& after, const formats::Subject& mesh,
                                const glm::ivec2& size) const {
    const auto old = before.triangleMeshes(), made = after.triangleMeshes();
    const auto refuse = [&](const std::string& found, const std::string& expected) {
        return failure(ErrorCode::Verification, mesh, fmt::format("found {}, expected {}", found, expected));
    };
    if (old.size() != made.size()) return refuse(fmt::format("{} primitives", made.size()), fmt::format("{}", old.size()));
    for (std::size_t i = 0; i < old.size(); ++i) {
        const formats::MeshAttribute *uvBefore = old[i]->find("TEXCOORD_1"), *uv = made[i]->find("TEXCOORD_1");
        if (uv == nullptr || uv->vertexCount() != uvBefore->vertexCount() || old[i]->indices != made[i]->indices)
            return refuse(fmt::format("another primitive {}", i), "the vertices and triangles that it had");
        for (std::size_t vertex = 0; vertex < uv->vertexCount(); ++vertex) {
            const std::uint32_t chart = charts_.ofVertex[i][vertex];
            if (chart == ChartSet::kNoChart) continue;
            const glm::dvec2 wanted = moved(chart, glm::dvec2(uvBefore->at(vertex)) * glm::dvec2(before_) - 0.5);
            const glm::dvec2 found = glm::dvec2(uv->at(vertex)) * glm::dvec2(size) - 0.5;
            const glm::dvec2 off = glm::abs(found - wanted);
            if (off.x <= kUvRounding && off.y <= kUvRounding) continue;
            return refuse(fmt::format("vertex {} of primitive {} at texel ({:.3f}, {:.3f})", vertex, i, found.x, found.y),
                          fmt::format("({:.3f}, {:.3f}), where its chart was packed", wanted.x, wanted.y));
        }
    }
    return {};
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
