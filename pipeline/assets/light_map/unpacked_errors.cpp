// Errors of a cooked light map whose charts were packed, against the bake as it was before.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <optional>
#include <random>
#include <span>
#include <utility>

#include "formats/gltf_scene.h"
#include "pipeline/assets/light_map/bake_filter.h"
#include "pipeline/assets/light_map/chart_places.h"
#include "pipeline/assets/light_map/checked_light_map.h"
#include "pipeline/assets/light_map/packed_reading.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::LightMapStrip;
using formats::Result;
using lighting::ShRgb;

/// Returns where the charts of the bake are now, after a check of both meshes.
Result<ChartPlaces> openPlaces(const UnpackedBake& unpacked, const ActionContext& context) {
    const auto& inputs = context.action.inputs;
    const auto old = inputs.find(kUnpackedMeshRole), made = inputs.find(kSurfaceRole);
    if (old == inputs.end() || made == inputs.end())
        return failure(ErrorCode::Verification, context.action.asset, "found no mesh of its packed charts, expected its file");
    LC_TRY(before, loadMesh(inputs, kUnpackedMeshRole, unpacked.description.places));
    LC_TRY(after, formats::GltfScene::load(made->second));
    const ChartPacking& packing = unpacked.packing;
    LC_TRY(places, ChartPlaces::create(*before, old->second, unpacked));
    LC_CHECK(places->check(*before, *after, made->second, {packing.width, packing.height}));
    return places;
}

/// A number in [-0.5, 0.5), the same on every machine.
double offset(std::mt19937_64& random) {
    return static_cast<double>(random() >> 11u) * 0x1p-53 - 0.5;
}

/// Returns the light of the bake at a place, filtered between covered texels alone; nothing if none of them is covered.
/// rows  the rows around the place, as far as the map has them
std::optional<ShRgb> filtered(const LightMapStrip& rows, const glm::dvec2& texel) {
    ShRgb sum{};
    double total = 0;
    forEachCoveredAround(rows, texel, [&](int x, int row, double weight) {
        total += weight;
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<float>(weight) * rows.sh.at(x, row)[i];
    });
    if (!(total > 0)) return std::nullopt;
    for (glm::vec3& coefficient : sum) coefficient /= static_cast<float>(total);
    return sum;
}

/// Judges some rows of the bake.
class RowJudge {
public:
    RowJudge(const CheckedLightMap& map, const ChartPlaces& charts, const verify::LightMapScore& score)
        : bake_(map.before->source), reading_{charts, map.cooked, &map.bake, map.key}, score_(score), context_(map.context) {}

    /// Adds the errors of rows [firstRow, firstRow + rowCount).
    Result<void> add(int firstRow, int rowCount, int placesPerTexel) {
        const int before = std::max(0, firstRow - 1), end = std::min(bake_.height(), firstRow + rowCount + 1);
        LC_TRY(rows, bake_.rows(before, end - before));
        std::vector<glm::ivec2> texels;
        for (int y = firstRow; y < firstRow + rowCount; ++y)
            for (int x = 0; x < bake_.width(); ++x) {
                if (rows->covered.at(x, y - before) == 0) continue;
                if (reading_.charts.packed({x, y}))
                    texels.emplace_back(x, y);
                else
                    ++unread;
            }
        std::vector<glm::dvec2> places(texels.begin(), texels.end());
        LC_CHECK(shade(*rows, texels, places, centres));
        for (int sample = 0; sample < placesPerTexel; ++sample) {
            std::mt19937_64 random(static_cast<std::uint64_t>(firstRow) * 4096 + static_cast<std::uint64_t>(sample));
            std::vector<glm::ivec2> near;
            places.clear();
            for (const glm::ivec2& texel : texels) {
                const double x = offset(random), y = offset(random);
                const glm::dvec2 place = glm::dvec2(texel) + glm::dvec2(x, y);
                if (!reading_.charts.packed(place)) continue;
                near.push_back(texel);
                places.push_back(place);
            }
            LC_CHECK(shade(*rows, near, places, surface));
        }
        return {};
    }

    verify::ShadedErrors centres, surface;
    std::int64_t unread = 0;

private:
    /// Adds the errors at one place for each of some texels, shaded at the texels' normals.
    Result<void> shade(const LightMapStrip& rows, const std::vector<glm::ivec2>& texels, const std::vector<glm::dvec2>& places,
                       verify::ShadedErrors& errors) {
        LC_TRY(decoded, decodedAt(places, reading_, context_));
        std::vector<verify::LightMapScore::Place> shaded;
        for (std::size_t i = 0; i < places.size(); ++i)
            if (const auto light = filtered(rows, places[i]))
                shaded.push_back({places[i], *light, (*decoded)[i], rows.normal.at(texels[i].x, texels[i].y - rows.firstRow)});
        // Parts are merged in order.
        constexpr std::size_t kPart = 4096;
        const auto shadePart = [&](int part) -> Result<verify::ShadedErrors> {
            const std::span<const verify::LightMapScore::Place> all(shaded);
            const std::size_t first = static_cast<std::size_t>(part) * kPart;
            return score_.score(all.subspan(first, std::min(kPart, all.size() - first)));
        };
        return foldInOrder<verify::ShadedErrors>(static_cast<int>((shaded.size() + kPart - 1) / kPart), context_,
                                                 "verify " + context_.action.asset, shadePart,
                                                 [&](const verify::ShadedErrors& part) { errors.merge(part); });
    }

    LightMapSource& bake_;
    PackedReading reading_;
    const verify::LightMapScore& score_;
    const ActionContext& context_;
};

/// Adds the verdict against the bake from before its charts were packed. Where charts were moved only, the light of the repacked bake at
/// every place of the surface is that of the bake, and so are the bounds, also at the bake's texels. Else nothing bounds the errors against
/// the bake (docs/guide/memory-budgets.md).
void addUnpackedStage(std::vector<verify::StageError>& stages, verify::StageError total, bool isMovedOnly) {
    verify::StageError& repacked = stages.back();
    const auto takeBound = [&](verify::ErrorFigures& figures, const verify::ErrorFigures& known) {
        figures.maxBound = isMovedOnly ? known.maxBound : std::nullopt;
    };
    const auto takeBounds = [&](verify::ErrorFigures& figures, const verify::ErrorFigures& known) {
        takeBound(figures, known);
        if (isMovedOnly && figures.visible && known.visible) figures.visible->bound = known.visible->bound;
    };
    takeBounds(total.diffuse, repacked.diffuse);
    takeBounds(total.specular, repacked.specular);
    if (total.atTexels) {
        takeBound(total.atTexels->diffuse, repacked.diffuse);
        takeBound(total.atTexels->specular, repacked.specular);
    }
    total.name = std::exchange(repacked.name, kRepackedStage);
    stages.push_back(std::move(total));
}

}  // namespace

/// Measures the errors at the covered texel centres of the bake that triangles read, and at random places of their footprints on the
/// surface, where the bake is filtered between covered texels alone.
Result<void> checkPacking(CheckedLightMap& map) {
    const UnpackedBake& unpacked = map.before->unpacked;
    LC_TRY(charts, openPlaces(unpacked, map.context));
    LC_TRY(score, verify::LightMapScore::create(map.parameters.shading, map.key, map.viewing));
    LightMapSource& bake = map.before->source;
    RowJudge judge(map, *charts, *score);
    const int rowsAtOnce = std::max(1, kPlacesAtOnce / bake.width());
    for (int row = 0; row < bake.height(); row += rowsAtOnce)
        LC_CHECK(judge.add(row, std::min(rowsAtOnce, bake.height() - row), map.parameters.samples));
    std::vector<verify::LightMapErrors::Stage> centres;
    centres.push_back({"centres", std::move(judge.centres)});
    verify::LightMapErrors errors(std::move(centres));
    errors.surface = std::move(judge.surface);
    map.result.measures = Json{{note_keys::kUnreadTexels, judge.unread}};
    addUnpackedStage(map.result.verdict.stages, errors.figures().back(), unpacked.packing.reducedCharts == 0);
    return {};
}

}  // namespace lightcook::pipeline
