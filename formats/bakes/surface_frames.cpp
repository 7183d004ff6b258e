#include "formats/bakes/surface_frames.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "formats/gltf/triangle_mesh.h"
#include "formats/gltf_scene.h"
#include "lighting/sphere.h"

namespace lightcook::formats {
namespace {

/// Returns v at length 1, or 0 if it has no direction.
glm::dvec3 unit(const glm::dvec3& v) {
    const double length = glm::length(v);
    return length > 0 && std::isfinite(length) ? v / length : glm::dvec3(0);
}

glm::dvec3 across(const glm::dvec3& v, const glm::dvec3& normal) {
    return v - glm::dot(v, normal) * normal;
}

/// Returns the share of b in the point of segment a b that is closest to p.
double shareOfSegment(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
    const double square = glm::dot(b - a, b - a);
    return square > 0 ? std::clamp(glm::dot(p - a, b - a) / square, 0.0, 1.0) : 0.0;
}

/// Returns the weights of the corners at the point of a triangle that is closest to p.
glm::dvec3 weightsAt(const glm::dvec2& p, const std::array<glm::dvec2, 3>& at) {
    const auto cross = [](const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; };
    const double area = cross(at[1] - at[0], at[2] - at[0]);
    if (area != 0) {
        const glm::dvec3 inside(cross(at[1] - p, at[2] - p) / area, cross(at[2] - p, at[0] - p) / area, cross(at[0] - p, at[1] - p) / area);
        if (inside.x >= 0 && inside.y >= 0 && inside.z >= 0) return inside;
    }
    glm::dvec3 best(1, 0, 0);
    double least = std::numeric_limits<double>::max();
    for (int first = 0; first < 3; ++first) {
        const int second = (first + 1) % 3;
        const glm::dvec2 &a = at[static_cast<std::size_t>(first)], &b = at[static_cast<std::size_t>(second)];
        const double share = shareOfSegment(p, a, b);
        const glm::dvec2 off = a + share * (b - a) - p;
        if (!(glm::dot(off, off) < least)) continue;
        least = glm::dot(off, off);
        best = glm::dvec3(0);
        best[first] = 1 - share;
        best[second] = share;
    }
    return best;
}

/// A triangle of a mesh in the mesh's own space.
struct MeshTriangle {
    std::array<std::uint32_t, 3> vertex;
    std::array<glm::dvec3, 3> position, normal;
};

MeshTriangle triangleOf(const TriangleMesh& mesh, std::size_t index) {
    const MeshAttribute &positions = *mesh.find("POSITION"), *normals = mesh.find("NORMAL");
    MeshTriangle triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
        triangle.vertex[i] = mesh.indices[3 * index + i];
        triangle.position[i] = positions.at(triangle.vertex[i]);
    }
    const glm::dvec3 face = unit(glm::cross(triangle.position[1] - triangle.position[0], triangle.position[2] - triangle.position[0]));
    for (std::size_t i = 0; i < 3; ++i) {
        if (normals != nullptr) triangle.normal[i] = unit(normals->at(triangle.vertex[i]));
        if (triangle.normal[i] == glm::dvec3(0)) triangle.normal[i] = face;
    }
    return triangle;
}

struct CornerTangents {
    std::array<glm::dvec3, 3> tangent{};
    double sign = 1;
};

/// The tangents of a mesh's corners.
class MeshTangents {
public:
    explicit MeshTangents(const TriangleMesh& mesh) : stored_(mesh.find("TANGENT")) {
        if (stored_ != nullptr && stored_->componentCount == 4) return;
        stored_ = nullptr;
        const MeshAttribute* const uvs = mesh.find("TEXCOORD_0");
        uvs_ = uvs != nullptr ? uvs : mesh.find("TEXCOORD_1");
        sums_.resize(mesh.vertexCount());
        for (std::size_t index = 0; index < mesh.triangleCount(); ++index) add(triangleOf(mesh, index));
    }

    CornerTangents of(const MeshTriangle& triangle) const {
        CornerTangents out;
        if (stored_ != nullptr) {
            for (std::size_t i = 0; i < 3; ++i) out.tangent[i] = stored_->at(triangle.vertex[i]);
            out.sign = stored_->component(triangle.vertex[0], 3) < 0 ? -1 : 1;
            return out;
        }
        out.sign = inUvs(triangle).sign;
        for (std::size_t i = 0; i < 3; ++i) out.tangent[i] = sums_[triangle.vertex[i]][out.sign > 0 ? 1 : 0];
        return out;
    }

private:
    struct InUvs {
        glm::dvec3 tangent{0};
        double sign = 1;
    };
    /// Returns the direction in which u grows, and how the triangle is turned.
    InUvs inUvs(const MeshTriangle& triangle) const {
        const auto uvAt = [&](std::size_t i) { return glm::dvec2(uvs_->at(triangle.vertex[i])); };
        const glm::dvec2 first = (uvAt(1) - uvAt(0)) * glm::dvec2(1, -1), second = (uvAt(2) - uvAt(0)) * glm::dvec2(1, -1);
        const glm::dvec3 right = triangle.position[1] - triangle.position[0], left = triangle.position[2] - triangle.position[0];
        const double area = first.x * second.y - second.x * first.y;
        if (area == 0) return {};
        const glm::dvec3 tangent = (right * second.y - left * first.y) / area, bitangent = (left * first.x - right * second.x) / area;
        const glm::dvec3 normal = triangle.normal[0] + triangle.normal[1] + triangle.normal[2];
        return {unit(tangent), glm::dot(glm::cross(normal, tangent), bitangent) < 0 ? -1.0 : 1.0};
    }
    void add(const MeshTriangle& triangle) {
        const InUvs found = inUvs(triangle);
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec3 &at = triangle.position[i], &next = triangle.position[(i + 1) % 3], &last = triangle.position[(i + 2) % 3];
            const double angle = std::acos(std::clamp(glm::dot(unit(next - at), unit(last - at)), -1.0, 1.0));
            sums_[triangle.vertex[i]][found.sign > 0 ? 1 : 0] += angle * unit(across(found.tangent, triangle.normal[i]));
        }
    }

    const MeshAttribute *stored_, *uvs_ = nullptr;
    std::vector<std::array<glm::dvec3, 2>> sums_;  ///< [vertex][turned as u and v up are]
};

}  // namespace

/// Collects the triangles of a scene.
class SurfaceBuilder {
public:
    SurfaceBuilder(int width, int height) : size_(width, height) {}

    void add(const GltfScene::Placed& placed) {
        const MeshAttribute* const lightMapUvs = placed.mesh->find("TEXCOORD_1");
        if (lightMapUvs == nullptr || placed.mesh->find("POSITION") == nullptr) return;
        const MeshTangents tangents(*placed.mesh);
        const glm::dmat3 linear(placed.worldFromMesh), ofNormals = glm::transpose(glm::inverse(linear));
        const double mirror = glm::determinant(linear) < 0 ? -1 : 1;
        for (std::size_t index = 0; index < placed.mesh->triangleCount(); ++index) {
            const MeshTriangle source = triangleOf(*placed.mesh, index);
            const CornerTangents found = tangents.of(source);
            SurfaceFrames::Triangle triangle;
            triangle.sign = static_cast<float>(mirror * found.sign);
            for (std::size_t i = 0; i < 3; ++i)
                triangle.corners[i] = {glm::vec2(glm::dvec2(lightMapUvs->at(source.vertex[i])) * size_),
                                       glm::vec3(unit(ofNormals * source.normal[i])), glm::vec3(unit(linear * found.tangent[i]))};
            triangles_.push_back(triangle);
        }
    }
    std::vector<SurfaceFrames::Triangle> take() { return std::move(triangles_); }

private:
    glm::dvec2 size_;
    std::vector<SurfaceFrames::Triangle> triangles_;
};

Result<SurfaceFrames> SurfaceFrames::load(const std::filesystem::path& mesh, int width, int height, const std::filesystem::path& lmbake,
                                          const std::vector<NodePlace>& places) {
    LC_TRY(scene, GltfScene::load(mesh, lmbake, places));
    SurfaceBuilder builder(width, height);
    for (const GltfScene::Placed& placed : scene->placedMeshes()) builder.add(placed);
    std::vector<Triangle> triangles = builder.take();
    if (triangles.empty()) return tl::make_unexpected(withoutLightMapUvs(mesh));
    return SurfaceFrames(std::move(triangles), width);
}

bool SurfaceFrames::hasTangents() const {
    return std::ranges::any_of(triangles_, [](const Triangle& triangle) {
        return std::ranges::any_of(triangle.corners, [](const Corner& corner) { return corner.tangent != glm::vec3(0); });
    });
}

void SurfaceFrames::turn(const BakeAxes& axes) {
    const auto turned = [&](const glm::vec3& vector) { return glm::vec3(axes(glm::dvec3(vector))); };
    for (Triangle& triangle : triangles_) {
        for (Corner& corner : triangle.corners) {
            corner.normal = turned(corner.normal);
            corner.tangent = turned(corner.tangent);
        }
        if (!axes.isRotation()) triangle.sign = -triangle.sign;  // a cross product is mirrored the other way
    }
}

SurfaceFrame SurfaceFrames::frameAt(const Triangle& triangle, const glm::dvec3& weights) {
    glm::dvec3 normal(0), tangent(0);
    for (int i = 0; i < 3; ++i) {
        const Corner& corner = triangle.corners[static_cast<std::size_t>(i)];
        normal += weights[i] * glm::dvec3(corner.normal);
        tangent += weights[i] * glm::dvec3(corner.tangent);
    }
    normal = unit(normal);
    if (normal == glm::dvec3(0)) return {};
    tangent = unit(across(tangent, normal));
    if (tangent == glm::dvec3(0)) tangent = lighting::worldFromTangentFrame(normal)[0];
    return {glm::vec3(tangent), glm::vec3(static_cast<double>(triangle.sign) * glm::cross(normal, tangent)), glm::vec3(normal)};
}

Image<SurfaceFrame> SurfaceFrames::rows(int firstRow, int rowCount, double margin) const {
    constexpr double kHalf = 0.5;
    Image<SurfaceFrame> frames(width_, rowCount);
    Image<double> distances(width_, rowCount, std::numeric_limits<double>::max());
    const auto firstOf = [](double low, int least) { return static_cast<int>(std::max(std::floor(low) - 1, static_cast<double>(least))); };
    const auto endOf = [](double high, int most) { return static_cast<int>(std::min(std::floor(high) + 2, static_cast<double>(most))); };
    for (const Triangle& triangle : triangles_) {
        std::array<glm::dvec2, 3> at;
        for (std::size_t i = 0; i < 3; ++i) at[i] = glm::dvec2(triangle.corners[i].place);
        const glm::dvec2 low = glm::min(glm::min(at[0], at[1]), at[2]), high = glm::max(glm::max(at[0], at[1]), at[2]);
        for (int y = firstOf(low.y, firstRow); y < endOf(high.y, firstRow + rowCount); ++y)
            for (int x = firstOf(low.x, 0); x < endOf(high.x, width_); ++x) {
                const glm::dvec2 centre(x + kHalf, y + kHalf);
                const glm::dvec3 weights = weightsAt(centre, at);
                const glm::dvec2 off = weights.x * at[0] + weights.y * at[1] + weights.z * at[2] - centre;
                const double distance = glm::dot(off, off);
                double& least = distances.at(x, y - firstRow);
                if (std::max(std::abs(off.x), std::abs(off.y)) > kHalf - margin || !(distance < least)) continue;
                const SurfaceFrame frame = frameAt(triangle, weights);
                if (!frame.isSurface()) continue;
                least = distance;
                frames.at(x, y - firstRow) = frame;
            }
    }
    return frames;
}

}  // namespace lightcook::formats
