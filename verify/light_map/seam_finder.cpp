#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "verify/seams.h"

namespace lightcook::verify {
namespace {

/// Ends of an edge, the smaller one first.
using EdgeKey = std::array<glm::dvec3, 2>;

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
    hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
    return hash ^ (hash >> 32);
}

struct HashOfEdge {
    std::size_t operator()(const EdgeKey& key) const {
        std::uint64_t hash = 0;
        for (const glm::dvec3& end : key)
            for (int axis = 0; axis < 3; ++axis) hash = mixed(hash, std::bit_cast<std::uint64_t>(end[axis]));
        return hash;
    }
};

using Cell = std::array<std::int64_t, 3>;
struct HashOfCell {
    std::size_t operator()(const Cell& cell) const {
        std::uint64_t hash = 0;
        for (const std::int64_t axis : cell) hash = mixed(hash, static_cast<std::uint64_t>(axis));
        return hash;
    }
};

bool isLess(const glm::dvec3& a, const glm::dvec3& b) {
    return std::tuple(a.x, a.y, a.z) < std::tuple(b.x, b.y, b.z);
}

/// One triangle at an edge. Ends are in the order of the key.
struct Side {
    std::array<glm::dvec2, 2> uv;
    std::array<glm::vec3, 2> normal;
    glm::vec3 inward;  ///< unit, from the edge into the triangle
    std::uint64_t order;
};

using OpenEdges = std::unordered_map<EdgeKey, std::vector<Side>, HashOfEdge>;

/// Replaces positions by the first one that was seen within a tolerance.
class Welder {
public:
    explicit Welder(double tolerance) : tolerance_(tolerance) {}
    glm::dvec3 operator()(const glm::dvec3& position) {
        // Cells are twice as large as the tolerance: what is close lies in one of eight.
        const glm::dvec3 scaled = position / (2 * tolerance_), nearest = glm::floor(scaled + 0.5);
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 cell = nearest - glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
            const auto found = seen_.find(indexOf(cell));
            if (found == seen_.end()) continue;
            for (const glm::dvec3& other : found->second)
                if (glm::all(glm::lessThanEqual(glm::abs(other - position), glm::dvec3(tolerance_)))) return other;
        }
        seen_[indexOf(glm::floor(scaled))].push_back(position);
        return position;
    }

private:
    static Cell indexOf(const glm::dvec3& cell) {
        return {static_cast<std::int64_t>(cell.x), static_cast<std::int64_t>(cell.y), static_cast<std::int64_t>(cell.z)};
    }
    double tolerance_;
    std::unordered_map<Cell, std::vector<glm::dvec3>, HashOfCell> seen_;
};

glm::vec3 unitOr(const glm::vec3& vector, const glm::vec3& otherwise) {
    const float length = glm::length(vector);
    return length > 0 && std::isfinite(length) ? vector / length : otherwise;
}

}  // namespace

glm::dvec2 SplitEdge::texelAt(std::size_t side, double along, const glm::dvec2& size) const {
    return glm::clamp(glm::mix(uv.at(side)[0], uv.at(side)[1], along) * size, glm::dvec2(0), size) - 0.5;
}

glm::dvec3 SplitEdge::positionAt(double along) const {
    return glm::mix(position[0], position[1], along);
}

glm::vec3 SplitEdge::normalAt(double along) const {
    return unitOr(glm::mix(normal[0], normal[1], static_cast<float>(along)), normal[0]);
}

int SplitEdge::placeCount(const glm::dvec2& size) const {
    double length = 0;
    for (std::size_t side = 0; side < 2; ++side) length = std::max(length, glm::length(texelAt(side, 1, size) - texelAt(side, 0, size)));
    return std::max(1, static_cast<int>(std::ceil(length))) + 1;
}

struct SeamFinder::State {
    glm::dvec2 size;  ///< of the light map [texels]
    double largestCoordinate = 0;
    std::uint64_t sides = 0;
    OpenEdges open;
    SplitEdges found;
    std::vector<std::pair<std::uint64_t, SplitEdge>> split;  ///< with the order of the second side

    explicit State(const glm::dvec2& mapSize) : size(mapSize) {}

    /// Returns true if light may go on smoothly from one side to the other.
    static bool isSmooth(const Side& a, const Side& b) {
        constexpr float kFolded = 0.5f;
        static const auto kLeastCosine = static_cast<float>(std::cos(kHardAngle * std::numbers::pi / 180));
        if (glm::dot(a.inward, b.inward) > kFolded) return false;
        return glm::dot(a.normal[0], b.normal[0]) >= kLeastCosine && glm::dot(a.normal[1], b.normal[1]) >= kLeastCosine;
    }
    bool hasSameTexels(const Side& a, const Side& b) const {
        const auto isClose = [&](std::size_t end) { return glm::length((a.uv[end] - b.uv[end]) * size) <= kSameTexels; };
        return isClose(0) && isClose(1);
    }
    /// Returns the waiting side that continues this one: if several do, one that reads the same texels.
    std::vector<Side>::iterator partnerOf(const Side& side, std::vector<Side>& waiting) const {
        auto partner = waiting.end();
        for (auto other = waiting.begin(); other != waiting.end(); ++other) {
            if (!isSmooth(side, *other)) continue;
            if (hasSameTexels(side, *other)) return other;
            if (partner == waiting.end()) partner = other;
        }
        return partner;
    }
    /// Matches a side with one that waits at the same edge; without one it waits itself.
    void match(const EdgeKey& key, const Side& side, OpenEdges& edges) {
        const auto at = edges.try_emplace(key).first;
        std::vector<Side>& waiting = at->second;
        const auto partner = partnerOf(side, waiting);
        if (partner == waiting.end()) {
            waiting.push_back(side);
            return;
        }
        if (hasSameTexels(side, *partner)) {
            ++found.joined;
        } else {
            SplitEdge edge{key, {partner->uv, side.uv}, {}};
            for (std::size_t end = 0; end < 2; ++end) edge.normal[end] = glm::normalize(partner->normal[end] + side.normal[end]);
            split.emplace_back(side.order, edge);
        }
        waiting.erase(partner);
        if (waiting.empty()) edges.erase(at);
    }
    void matchLooseEdges();
};

SeamFinder::SeamFinder(const glm::dvec2& size) : state_(std::make_unique<State>(size)) {}
SeamFinder::SeamFinder(SeamFinder&&) noexcept = default;
SeamFinder& SeamFinder::operator=(SeamFinder&&) noexcept = default;
SeamFinder::~SeamFinder() = default;

void SeamFinder::add(const SurfaceTriangle& triangle) {
    const auto& p = triangle.position;
    const glm::dvec3 area = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double twiceArea = glm::length(area);
    if (!(twiceArea > 0) || !std::isfinite(twiceArea)) return;
    const glm::vec3 ownNormal(area / twiceArea);
    for (std::size_t corner = 0; corner < 3; ++corner) {
        std::array<std::size_t, 2> ends = {corner, (corner + 1) % 3};
        if (isLess(p[ends[1]], p[ends[0]])) std::swap(ends[0], ends[1]);
        EdgeKey key;
        Side side{};
        for (std::size_t end = 0; end < 2; ++end) {
            key[end] = p[ends[end]] + 0.0;  // -0 becomes 0
            side.uv[end] = triangle.uv[ends[end]];
            side.normal[end] = unitOr(triangle.normal[ends[end]], ownNormal);
            for (int axis = 0; axis < 3; ++axis) state_->largestCoordinate = std::max(state_->largestCoordinate, std::abs(key[end][axis]));
        }
        const glm::dvec3 edge = key[1] - key[0];
        const glm::dvec3 inward = p[(corner + 2) % 3] - key[0];
        const glm::dvec3 across = inward - glm::dot(inward, edge) / glm::dot(edge, edge) * edge;
        side.inward = unitOr(glm::vec3(across / std::max(glm::length(across), std::numeric_limits<double>::min())), glm::vec3(0));
        side.order = state_->sides++;
        state_->match(key, side, state_->open);
    }
}

/// Matches edges of one triangle alone once more, by positions that are close.
void SeamFinder::State::matchLooseEdges() {
    struct Loose {
        EdgeKey key;
        Side side;
    };
    std::vector<Loose> loose;
    for (auto& [key, waiting] : open) {
        if (waiting.size() == 1) loose.push_back({key, waiting.front()});
        found.hard += waiting.size() > 1 ? 1 : 0;
    }
    open.clear();
    std::ranges::sort(loose, {}, [](const Loose& each) { return each.side.order; });
    const double tolerance = kWeldTolerance * largestCoordinate;
    Welder welded(std::max(tolerance, std::numeric_limits<double>::min()));
    OpenEdges edges;
    for (Loose& each : loose) {
        if (glm::distance(each.key[0], each.key[1]) > 4 * tolerance) {
            for (glm::dvec3& end : each.key) end = welded(end);
            if (isLess(each.key[1], each.key[0])) {
                std::swap(each.key[0], each.key[1]);
                std::swap(each.side.uv[0], each.side.uv[1]);
                std::swap(each.side.normal[0], each.side.normal[1]);
            }
        }
        match(each.key, each.side, edges);
    }
    for (const auto& [key, waiting] : edges) ++(waiting.size() > 1 ? found.hard : found.open);
}

SplitEdges SeamFinder::finish() && {
    state_->matchLooseEdges();
    std::ranges::stable_sort(state_->split, {}, [](const auto& each) { return each.first; });
    for (const auto& [order, edge] : state_->split) state_->found.edges.push_back(edge);
    return std::move(state_->found);
}

}  // namespace lightcook::verify
