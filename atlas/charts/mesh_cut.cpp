// Method:
// 1. Each triangle is cut into convex pieces, each in tiles of one map (TriangleCutter). The range of tiles under a piece is halved along
// its
//    longer axis, and the piece with it, until all tiles of the range belong to one map.
// 2. The points that cuts make on edges are collected by the positions of the edge's ends (EdgePoints). So the triangles on both sides of
// an
//    edge, in any mesh, get the same vertices.
// 3. The pieces of a map become triangles with all of these points as vertices (PieceTriangles): a fan around a corner of the piece whose
// two
//    sides have no points between their ends, or else around a new vertex in the middle of the piece.
#include "atlas/mesh_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace lightcook::atlas {
namespace {

using formats::CutMesh;
using formats::CutVertex;
using formats::MeshAttribute;
using formats::TriangleMesh;

/// A corner this near to a line lies on it [texels]: UVs are floats, and samplers round places to 1/256 of a texel (kPlaceRounding).
constexpr double kOnLine = 1.0 / 1024;
/// Points on an edge are rounded to this part of it, so that the two triangles of an edge find the same ones.
constexpr double kEdgeSteps = 1 << 24;
/// Triangles with less area in the light map are not cut [texels^2].
constexpr double kLeastArea = 1e-9;

using Position = std::array<double, 3>;
using EdgeKey = std::pair<Position, Position>;  ///< positions of both ends, the lower one first

/// A side of a piece lies on a side of its triangle or on a line of the grid.
struct Side {
    int edge = -1;  ///< 0 .. 2: from that corner of the triangle to the next; -1: a line
    int axis = 0;
    double line = 0;
};

/// A point of a piece: a corner of the triangle, a point on one of its edges, or a crossing of two lines.
struct Point {
    int corner = -1, edge = -1;
    double along = 0;  ///< part of the edge from its lower end
    glm::dvec2 at{0};  ///< place in the light map [texels; integers are centres]
    Side side = {};    ///< from this point to the next
};

/// A convex part of a triangle in tiles of one map.
struct Piece {
    std::vector<Point> points;
    std::uint8_t map;
};

/// An edge of a triangle, from the vertex with the lower position.
struct Edge {
    EdgeKey key;
    std::uint32_t low = 0, high = 0;  ///< vertices
    bool isTurned = false;            ///< the triangle's corner is the high end
};

struct Triangle {
    std::array<std::uint32_t, 3> vertices{};
    std::array<glm::dvec2, 3> at{};  ///< places in the light map
    std::array<Edge, 3> edges{};

    double doubleArea() const {
        const glm::dvec2 a = at[1] - at[0], b = at[2] - at[0];
        return a.x * b.y - a.y * b.x;
    }
};

Edge edgeBetween(const MeshAttribute& position, std::uint32_t from, std::uint32_t to) {
    const auto positionOf = [&](std::uint32_t vertex) {
        const glm::dvec3 at = position.at(vertex);
        return Position{at.x, at.y, at.z};
    };
    const Position a = positionOf(from), b = positionOf(to);
    return b < a ? Edge{{b, a}, to, from, true} : Edge{{a, b}, from, to, false};
}

/// Returns a sign for a place beside a line: 0 on it.
int sideOf(double at, double line) {
    const double distance = at - line;
    if (std::abs(distance) < kOnLine) return 0;
    return distance < 0 ? -1 : 1;
}

/// Returns the corners of a triangle as a piece.
std::vector<Point> pointsOf(const Triangle& triangle) {
    std::vector<Point> points(3);
    for (int corner = 0; corner < 3; ++corner) {
        const auto i = static_cast<std::size_t>(corner);
        points[i] = {corner, -1, 0, triangle.at[i], {corner, 0, 0}};
    }
    return points;
}

/// Cuts one triangle into pieces.
class TriangleCutter {
public:
    TriangleCutter(const Triangle& triangle, std::size_t chart, const TileDivision& division)
        : triangle_(triangle), chart_(chart), tiles_(division.tiles), mapOf_(division.mapOf) {}

    std::vector<Piece> cut() {
        std::vector<Point> whole = pointsOf(triangle_);
        if (std::abs(triangle_.doubleArea()) < 2 * kLeastArea) {
            const glm::ivec2 quad(glm::floor(triangle_.at[0]));
            pieces_.push_back({std::move(whole), mapOf_[static_cast<std::size_t>(tiles_.ofQuad(chart_, quad))]});
        } else {
            cut(std::move(whole), glm::ivec2(0), tiles_.gridOf(chart_));
        }
        return std::move(pieces_);
    }

private:
    /// Cuts a piece that lies in columns and rows [first, end) of the grid.
    void cut(std::vector<Point> points, glm::ivec2 first, glm::ivec2 end) {
        narrow(points, first, end);
        const auto mapAt = [&](int x, int y) { return mapOf_[static_cast<std::size_t>(tiles_.at(chart_, {x, y}))]; };
        bool isUniform = true;
        for (int y = first.y; y < end.y; ++y)
            for (int x = first.x; x < end.x; ++x) isUniform = isUniform && mapAt(x, y) == mapAt(first.x, first.y);
        if (isUniform) {
            pieces_.push_back({std::move(points), mapAt(first.x, first.y)});
            return;
        }
        const glm::ivec2 count = end - first;
        const int axis = count.x >= count.y ? 0 : 1;
        const int middle = first[axis] + count[axis] / 2;
        glm::ivec2 lowEnd = end, highFirst = first;
        lowEnd[axis] = highFirst[axis] = middle;
        const double line = tiles_.line(chart_, axis, middle);
        if (auto low = half(points, axis, line, -1)) cut(std::move(*low), first, lowEnd);
        if (auto high = half(points, axis, line, 1)) cut(std::move(*high), highFirst, end);
    }

    /// Leaves out columns and rows that the piece does not come into. One that begins at the texel centre beside a line begins there: an
    /// edge of a mesh often lies on texel centres.
    void narrow(const std::vector<Point>& points, glm::ivec2& first, glm::ivec2& end) const {
        for (int axis = 0; axis < 2; ++axis) {
            const auto reaches = [&](double line, int sign) {
                return std::ranges::any_of(points, [&](const Point& point) { return sideOf(point.at[axis], line) == sign; });
            };
            while (end[axis] - first[axis] > 1 && !reaches(tiles_.line(chart_, axis, first[axis] + 1) - kLineOffset, -1)) ++first[axis];
            while (end[axis] - first[axis] > 1 && !reaches(tiles_.line(chart_, axis, end[axis] - 1), 1)) --end[axis];
        }
    }

    /// Returns the part of a piece on one side of a line; nothing if it has no area there.
    std::optional<std::vector<Point>> half(const std::vector<Point>& points, int axis, double line, int sign) const {
        std::vector<Point> kept;
        bool hasArea = false;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Point &from = points[i], &to = points[(i + 1) % points.size()];
            const int start = sign * sideOf(from.at[axis], line), stop = sign * sideOf(to.at[axis], line);
            hasArea = hasArea || start > 0;
            if (start >= 0) kept.push_back(from);
            if (start == 0 && stop < 0) kept.back().side = {-1, axis, line};
            if (start * stop >= 0) continue;
            kept.push_back(crossing(from, axis, line));
            if (start > 0) kept.back().side = {-1, axis, line};
        }
        if (!hasArea) return std::nullopt;
        return kept;
    }

    /// Returns the point where a line crosses the side that begins at a point, as the beginning of the rest of that side.
    Point crossing(const Point& from, int axis, double line) const {
        Point point{-1, from.side.edge, 0, glm::dvec2(0), from.side};
        if (point.edge < 0) {
            point.at[axis] = line;
            point.at[from.side.axis] = from.side.line;
            return point;
        }
        const auto [low, high] = endsOf(point.edge);
        point.along = std::round((line - low[axis]) / (high[axis] - low[axis]) * kEdgeSteps) / kEdgeSteps;
        point.at = low + point.along * (high - low);
        return point;
    }
    std::pair<glm::dvec2, glm::dvec2> endsOf(int edge) const {
        const auto from = static_cast<std::size_t>(edge), to = (from + 1) % 3;
        if (triangle_.edges[from].isTurned) return {triangle_.at[to], triangle_.at[from]};
        return {triangle_.at[from], triangle_.at[to]};
    }

    const Triangle& triangle_;
    std::size_t chart_;
    const Tiles& tiles_;
    const std::vector<std::uint8_t>& mapOf_;
    std::vector<Piece> pieces_;
};

/// Collects the triangles of a mesh and numbers their vertices.
class MeshCollector {
public:
    explicit MeshCollector(std::size_t vertexCount) : isUsed_(vertexCount, 0) {}

    std::uint32_t vertex(std::uint32_t source) {
        isUsed_[source] = 1;
        return source;
    }
    std::uint32_t onEdge(const Edge& edge, double along) {
        const auto [found, isNew] = onEdges_.try_emplace({edge.low, edge.high, along}, next());
        if (isNew) made_.push_back({{edge.low, edge.high, edge.high}, {1 - along, along, 0}});
        return found->second;
    }
    std::uint32_t inside(const std::array<std::uint32_t, 3>& vertices, const std::array<double, 3>& weights) {
        const std::uint32_t index = next();
        made_.push_back({vertices, weights});
        return index;
    }
    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) { indices_.insert(indices_.end(), {a, b, c}); }

    /// Returns the mesh: vertices of the source in their old order, then the new ones.
    CutMesh finish() {
        CutMesh mesh;
        std::vector<std::uint32_t> newIndex(isUsed_.size() + made_.size());
        for (std::size_t i = 0; i < isUsed_.size(); ++i) {
            if (isUsed_[i] == 0) continue;
            newIndex[i] = static_cast<std::uint32_t>(mesh.vertices.size());
            const auto source = static_cast<std::uint32_t>(i);
            mesh.vertices.push_back({{source, source, source}, {1, 0, 0}});
        }
        for (std::size_t i = 0; i < made_.size(); ++i) newIndex[isUsed_.size() + i] = static_cast<std::uint32_t>(mesh.vertices.size() + i);
        mesh.vertices.insert(mesh.vertices.end(), made_.begin(), made_.end());
        for (const std::uint32_t index : indices_) mesh.indices.push_back(newIndex[index]);
        return mesh;
    }

private:
    std::uint32_t next() const { return static_cast<std::uint32_t>(isUsed_.size() + made_.size()); }

    std::vector<std::uint8_t> isUsed_;  ///< of each vertex of the source
    std::vector<CutVertex> made_;       ///< the others
    std::map<std::tuple<std::uint32_t, std::uint32_t, double>, std::uint32_t> onEdges_;
    std::vector<std::uint32_t> indices_;
};

using EdgePoints = std::map<EdgeKey, std::set<double>>;

/// Makes triangles of the pieces of one triangle.
class PieceTriangles {
public:
    PieceTriangles(const Triangle& triangle, const EdgePoints& edgePoints, const std::vector<Piece>& pieces, MeshCollector& mesh)
        : triangle_(triangle), mesh_(mesh) {
        for (std::size_t i = 0; i < 3; ++i) {
            const auto found = edgePoints.find(triangle.edges[i].key);
            onEdge_[i] = found != edgePoints.end() ? &found->second : nullptr;
        }
        for (const Piece& piece : pieces)
            for (std::size_t i = 0; i < piece.points.size(); ++i) {
                const Point &from = piece.points[i], &to = piece.points[(i + 1) % piece.points.size()];
                if (from.side.edge >= 0) continue;
                std::map<double, Point>& onLine = onLine_[{from.side.axis, from.side.line}];
                for (const Point* point : {&from, &to}) onLine.try_emplace(point->at[1 - from.side.axis], *point);
            }
    }

    void add(const Piece& piece) {
        std::vector<Point> rim;
        std::vector<std::size_t> corners;  // of the piece, in the rim
        for (std::size_t i = 0; i < piece.points.size(); ++i) {
            corners.push_back(rim.size());
            rim.push_back(piece.points[i]);
            addBetween(piece.points[i], piece.points[(i + 1) % piece.points.size()], rim);
        }
        std::vector<std::uint32_t> vertices;
        for (const Point& point : rim) vertices.push_back(vertexOf(point));
        const std::size_t count = rim.size();
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const std::size_t before = corners[(i + corners.size() - 1) % corners.size()], at = corners[i],
                              after = corners[(i + 1) % corners.size()];
            if ((before + 1) % count != at || (at + 1) % count != after) continue;  // more points on a side: triangles without area
            for (std::size_t step = 1; step + 1 < count; ++step)
                mesh_.add(vertices[at], vertices[(at + step) % count], vertices[(at + step + 1) % count]);
            return;
        }
        std::array<double, 3> middle{};
        for (const std::size_t corner : corners) {
            const std::array<double, 3> weights = weightsOf(rim[corner]);
            for (std::size_t i = 0; i < 3; ++i) middle[i] += weights[i] / static_cast<double>(corners.size());
        }
        const std::uint32_t centre = mesh_.inside(triangle_.vertices, middle);
        for (std::size_t i = 0; i < count; ++i) mesh_.add(centre, vertices[i], vertices[(i + 1) % count]);
    }

private:
    /// Adds the points between the ends of a side, in its direction.
    void addBetween(const Point& from, const Point& to, std::vector<Point>& rim) const {
        std::vector<Point> between;
        if (from.side.edge >= 0) {
            const auto edge = static_cast<std::size_t>(from.side.edge);
            if (onEdge_[edge] == nullptr) return;
            const double start = alongOf(from, edge), stop = alongOf(to, edge);
            for (const double along : *onEdge_[edge])
                if (std::min(start, stop) < along && along < std::max(start, stop))
                    between.push_back({-1, from.side.edge, along, glm::dvec2(0), {}});
            if (stop < start) std::ranges::reverse(between);
        } else {
            const int other = 1 - from.side.axis;
            const double start = from.at[other], stop = to.at[other];
            for (const auto& [at, point] : onLine_.at({from.side.axis, from.side.line}))
                if (std::min(start, stop) < at && at < std::max(start, stop)) between.push_back(point);
            if (stop < start) std::ranges::reverse(between);
        }
        rim.insert(rim.end(), between.begin(), between.end());
    }
    /// Returns the part of an edge at which a point on it lies.
    double alongOf(const Point& point, std::size_t edge) const {
        if (point.corner < 0) return point.along;
        const bool isStart = static_cast<std::size_t>(point.corner) == edge;
        return isStart != triangle_.edges[edge].isTurned ? 0 : 1;
    }
    std::uint32_t vertexOf(const Point& point) {
        if (point.corner >= 0) return mesh_.vertex(triangle_.vertices[static_cast<std::size_t>(point.corner)]);
        if (point.edge >= 0) return mesh_.onEdge(triangle_.edges[static_cast<std::size_t>(point.edge)], point.along);
        const auto known = crossings_.find({point.at.x, point.at.y});
        if (known != crossings_.end()) return known->second;
        return crossings_[{point.at.x, point.at.y}] = mesh_.inside(triangle_.vertices, weightsOf(point));
    }
    /// Returns the weights of the corners of the triangle at a point.
    std::array<double, 3> weightsOf(const Point& point) const {
        std::array<double, 3> weights{};
        if (point.corner >= 0) {
            weights[static_cast<std::size_t>(point.corner)] = 1;
        } else if (point.edge >= 0) {
            const auto from = static_cast<std::size_t>(point.edge);
            const double toNext = triangle_.edges[from].isTurned ? 1 - point.along : point.along;
            weights[from] = 1 - toNext;
            weights[(from + 1) % 3] = toNext;
        } else {
            const glm::dvec2 a = triangle_.at[1] - triangle_.at[0], b = triangle_.at[2] - triangle_.at[0], p = point.at - triangle_.at[0];
            const double area = triangle_.doubleArea();
            weights[1] = std::clamp((p.x * b.y - p.y * b.x) / area, 0.0, 1.0);
            weights[2] = std::clamp((a.x * p.y - a.y * p.x) / area, 0.0, 1 - weights[1]);
            weights[0] = 1 - weights[1] - weights[2];
        }
        return weights;
    }

    const Triangle& triangle_;
    MeshCollector& mesh_;
    std::array<const std::set<double>*, 3> onEdge_{};
    std::map<std::pair<int, double>, std::map<double, Point>> onLine_;  ///< [axis, line][place along it]
    std::map<std::pair<double, double>, std::uint32_t> crossings_;
};

/// The triangles of a mesh, and how they are cut.
class MeshCutter {
public:
    /// chartOf     chart of each vertex
    /// edgePoints  gets the points of cuts on edges
    MeshCutter(const TriangleMesh& mesh, const std::vector<std::uint32_t>& chartOf, const TileDivision& division, EdgePoints& edgePoints)
        : mesh_(mesh), position_(*mesh.find("POSITION")), uv_(*mesh.find("TEXCOORD_1")), size_(division.size) {
        for (std::size_t i = 0; i < mesh.triangleCount(); ++i) {
            const Triangle triangle = triangleAt(i);
            std::vector<Piece> pieces = TriangleCutter(triangle, chartOf[triangle.vertices[0]], division).cut();
            maps_.push_back(pieces.front().map);
            if (pieces.size() == 1) continue;
            for (const Piece& piece : pieces)
                for (const Point& point : piece.points)
                    if (point.edge >= 0) edgePoints[triangle.edges[static_cast<std::size_t>(point.edge)].key].insert(point.along);
            pieces_.emplace(i, std::move(pieces));
        }
    }

    /// Returns the triangles of a map.
    CutMesh trianglesOf(std::uint8_t map, const EdgePoints& edgePoints) const {
        MeshCollector collector(mesh_.vertexCount());
        for (std::size_t i = 0; i < maps_.size(); ++i) {
            const auto cut = pieces_.find(i);
            if (cut == pieces_.end() && maps_[i] != map) continue;
            const Triangle triangle = triangleAt(i);
            const std::vector<Piece> whole = {{pointsOf(triangle), map}};
            const std::vector<Piece>& pieces = cut != pieces_.end() ? cut->second : whole;
            PieceTriangles triangles(triangle, edgePoints, pieces, collector);
            for (const Piece& piece : pieces)
                if (piece.map == map) triangles.add(piece);
        }
        return collector.finish();
    }

private:
    Triangle triangleAt(std::size_t index) const {
        Triangle triangle;
        for (std::size_t i = 0; i < 3; ++i) {
            triangle.vertices[i] = mesh_.indices[3 * index + i];
            triangle.at[i] = glm::dvec2(uv_.at(triangle.vertices[i])) * glm::dvec2(size_) - 0.5;
        }
        for (std::size_t i = 0; i < 3; ++i)
            triangle.edges[i] = edgeBetween(position_, triangle.vertices[i], triangle.vertices[(i + 1) % 3]);
        return triangle;
    }

    const TriangleMesh& mesh_;
    const MeshAttribute& position_;
    const MeshAttribute& uv_;
    glm::ivec2 size_;
    std::map<std::size_t, std::vector<Piece>> pieces_;  ///< of triangles that are cut
    std::vector<std::uint8_t> maps_;                    ///< of each triangle; of a cut one, that of its first piece
};

}  // namespace

std::vector<CutMesh> cutMeshes(std::span<const TriangleMesh* const> meshes, const TileDivision& division, std::uint8_t map) {
    EdgePoints edgePoints;
    std::vector<MeshCutter> cutters;
    cutters.reserve(meshes.size());
    for (std::size_t i = 0; i < meshes.size(); ++i) cutters.emplace_back(*meshes[i], division.charts.ofVertex[i], division, edgePoints);
    std::vector<CutMesh> cut;
    for (const MeshCutter& cutter : cutters) cut.push_back(cutter.trianglesOf(map, edgePoints));
    return cut;
}

}  // namespace lightcook::atlas
