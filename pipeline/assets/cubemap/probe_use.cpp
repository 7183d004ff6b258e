#include "pipeline/assets/cubemap/probe_use.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "formats/environment.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

constexpr double kMostPlacesOfAnEdge = 64;

double leastDistance(const std::vector<glm::dvec3>& positions) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < positions.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) least = std::min(least, glm::distance(positions[i], positions[j]));
    return least;
}

}  // namespace

ProbeUse::ProbeUse(std::vector<glm::dvec3> positions)
    : positions_(std::move(positions)), isUsed_(positions_.size(), false), spacing_(leastDistance(positions_) / 2) {}

void ProbeUse::add(const formats::TriangleMesh& mesh, const glm::dmat4& worldFromMesh) {
    const formats::MeshAttribute* const positions = mesh.find("POSITION");
    if (positions == nullptr) return;
    const auto at = [&](std::size_t corner) { return glm::dvec3(worldFromMesh * glm::dvec4(positions->at(mesh.indices[corner]), 1)); };
    for (std::size_t triangle = 0; triangle < mesh.triangleCount(); ++triangle)
        addTriangle(at(3 * triangle), at(3 * triangle + 1), at(3 * triangle + 2));
}

void ProbeUse::addTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    // Probes at one place have no spacing: corners and centre must do.
    const double parts = spacing_ > 0 ? std::clamp(std::ceil(longest / spacing_), 1.0, kMostPlacesOfAnEdge) : 1.0;
    const int count = static_cast<int>(parts);
    for (int i = 0; i <= count; ++i)
        for (int j = 0; i + j <= count; ++j) addPlace(a + (b - a) * (i / parts) + (c - a) * (j / parts));
    addPlace((a + b + c) / 3.0);
}

void ProbeUse::addPlace(const glm::dvec3& place) {
    std::array<std::pair<double, std::size_t>, kProbesOfAPlace> nearest;
    nearest.fill({std::numeric_limits<double>::infinity(), 0});
    for (std::size_t i = 0; i < positions_.size(); ++i) {
        const glm::dvec3 away = positions_[i] - place;
        const std::pair each(glm::dot(away, away), i);
        if (!(each.first < nearest.back().first)) continue;
        nearest.back() = each;
        for (std::size_t k = nearest.size() - 1; k > 0 && nearest[k] < nearest[k - 1]; --k) std::swap(nearest[k], nearest[k - 1]);
    }
    for (const auto& [distance, probe] : nearest)
        if (std::isfinite(distance)) isUsed_[probe] = true;
}

Result<ActionOutcome> findUnusedProbes(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<ProbeUseParameters>(context));
    std::vector<std::string> names;
    std::vector<glm::dvec3> positions;
    for (const PlacedProbe& probe : parameters->probes) {
        Result<std::optional<glm::dvec3>> position = probe.position;
        if (!probe.position) position = formats::loadProbePosition(context.action.inputs.at(probe.role), probe.file);
        if (!position) return tl::make_unexpected(position.error());
        if (!*position) continue;
        names.push_back(probe.name);
        positions.push_back(**position);
    }
    ProbeUseResult result;
    if (positions.size() <= kProbesOfAPlace) return outcomeWith(result);
    ProbeUse use(std::move(positions));
    bool hasSurface = false;
    for (const std::string& role : parameters->meshes) {
        if (context.state.interrupted) return interrupted(context);
        LC_TRY(scene, formats::GltfScene::load(context.action.inputs.at(role)));
        for (const formats::GltfScene::Placed& placed : scene->placedMeshes()) {
            use.add(*placed.mesh, placed.worldFromMesh);
            hasSurface = hasSurface || placed.mesh->triangleCount() > 0;
        }
    }
    for (std::size_t i = 0; i < names.size(); ++i)
        if (hasSurface && !use.isUsed()[i]) result.unused.push_back(names[i]);
    return outcomeWith(result);
}

}  // namespace lightcook::pipeline
