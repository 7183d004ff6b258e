#include "pipeline/assets/light_map/mesh_view.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <utility>

namespace lightcook::pipeline {
namespace {

double cross2(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

/// Returns the weights of a triangle's corners at a place of the plane; nothing for a triangle without area.
std::optional<glm::dvec3> weightsAt(const std::array<glm::dvec2, 3>& corners, const glm::dvec2& place) {
    const double area = cross2(corners[1] - corners[0], corners[2] - corners[0]);
    if (area == 0 || !std::isfinite(area)) return std::nullopt;
    const double b = cross2(place - corners[0], corners[2] - corners[0]) / area;
    const double c = cross2(corners[1] - corners[0], place - corners[0]) / area;
    return glm::dvec3(1 - b - c, b, c);
}

bool isInside(const glm::dvec3& weights) {
    return weights.x >= 0 && weights.y >= 0 && weights.z >= 0;
}

/// Returns the place of a triangle of the plane that is nearest to another place.
glm::dvec2 nearestOf(const std::array<glm::dvec2, 3>& corners, const glm::dvec2& place) {
    glm::dvec2 nearest = corners[0];
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 from = corners[i], along = corners[(i + 1) % 3] - from;
        const double length = glm::dot(along, along);
        const glm::dvec2 on = from + (length > 0 ? std::clamp(glm::dot(place - from, along) / length, 0.0, 1.0) : 0.0) * along;
        if (const double distance = glm::dot(place - on, place - on); distance < least) {
            least = distance;
            nearest = on;
        }
    }
    return nearest;
}

std::optional<MeshPlace> placeOn(const verify::SurfaceTriangle& triangle, const glm::dvec3& weights, const glm::dvec2& size) {
    const glm::dvec3 a = triangle.position[1] - triangle.position[0], b = triangle.position[2] - triangle.position[0];
    const glm::dvec3 normal = glm::cross(a, b);
    const double area = glm::length(normal);
    const double texels = std::abs(cross2((triangle.uv[1] - triangle.uv[0]) * size, (triangle.uv[2] - triangle.uv[0]) * size));
    if (!(area > 0) || !(texels > 0)) return std::nullopt;
    MeshPlace place;
    for (std::size_t i = 0; i < 3; ++i) place.position += weights[static_cast<int>(i)] * triangle.position[i];
    place.normal = normal / area;
    place.texelSide = std::sqrt(area / texels);
    return place;
}

/// Returns the distance at which a ray meets a triangle; infinity if it does not.
/// Source: Moeller and Trumbore 1997, Fast, Minimum Storage Ray-Triangle Intersection.
double meets(const glm::dvec3& origin, const glm::dvec3& direction, const verify::SurfaceTriangle& triangle) {
    const glm::dvec3 a = triangle.position[1] - triangle.position[0], b = triangle.position[2] - triangle.position[0];
    const glm::dvec3 p = glm::cross(direction, b);
    const double determinant = glm::dot(a, p);
    if (determinant == 0) return HUGE_VAL;
    const glm::dvec3 t = origin - triangle.position[0], q = glm::cross(t, a);
    const double u = glm::dot(t, p) / determinant, v = glm::dot(direction, q) / determinant;
    if (!(u >= 0) || !(v >= 0) || !(u + v <= 1)) return HUGE_VAL;
    const double distance = glm::dot(b, q) / determinant;
    return distance > 0 ? distance : HUGE_VAL;
}

/// A corner in the camera's frame: right, up, depth.
struct Corner {
    glm::dvec3 position;
    glm::dvec2 uv;
};

/// Returns the part of a triangle that lies behind the clipping plane, a polygon of up to four corners.
/// Source: Sutherland and Hodgman 1974, Reentrant Polygon Clipping.
std::vector<Corner> clipped(const std::array<Corner, 3>& corners, double nearest) {
    std::vector<Corner> kept;
    for (std::size_t i = 0; i < 3; ++i) {
        const Corner &from = corners[i], &to = corners[(i + 1) % 3];
        const double a = from.position.z - nearest, b = to.position.z - nearest;
        if (a >= 0) kept.push_back(from);
        if ((a >= 0) != (b >= 0)) {
            const double part = a / (a - b);
            kept.push_back({glm::mix(from.position, to.position, part), glm::mix(from.uv, to.uv, part)});
        }
    }
    return kept;
}

/// The picture and its depths.
class Canvas {
public:
    explicit Canvas(int side) : uvs_(side, side, glm::dvec2(std::numeric_limits<double>::quiet_NaN())), depth_(side, side, HUGE_VAL) {}

    /// slope  of the camera
    void draw(const Corner& a, const Corner& b, const Corner& c, double slope) {
        const double half = 0.5 * uvs_.width();
        const std::array<const Corner*, 3> corners = {&a, &b, &c};
        std::array<glm::dvec2, 3> places;
        glm::dvec2 low(HUGE_VAL), high(-HUGE_VAL);
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec3& at = corners[i]->position;
            places[i] = {half * (1 + at.x / (slope * at.z)), half * (1 - at.y / (slope * at.z))};
            low = glm::min(low, places[i]);
            high = glm::max(high, places[i]);
        }
        const auto first = [&](double value) { return static_cast<int>(std::clamp(std::ceil(value - 0.5), 0.0, 2 * half)); };
        const auto last = [&](double value) { return static_cast<int>(std::clamp(std::floor(value - 0.5), -1.0, 2 * half - 1)); };
        for (int y = first(low.y); y <= last(high.y); ++y)
            for (int x = first(low.x); x <= last(high.x); ++x) {
                const auto weights = weightsAt(places, {x + 0.5, y + 0.5});
                if (!weights || !isInside(*weights)) continue;
                double inverse = 0;
                glm::dvec2 uv(0);
                for (std::size_t i = 0; i < 3; ++i) {
                    const double part = (*weights)[static_cast<int>(i)] / corners[i]->position.z;
                    inverse += part;
                    uv += part * corners[i]->uv;
                }
                if (!(1 / inverse < depth_.at(x, y))) continue;
                depth_.at(x, y) = 1 / inverse;
                uvs_.at(x, y) = uv / inverse;
            }
    }
    formats::Image<glm::dvec2> take() { return std::move(uvs_); }

private:
    formats::Image<glm::dvec2> uvs_;
    formats::Image<double> depth_;
};

}  // namespace

std::vector<verify::SurfaceTriangle> litTriangles(const formats::GltfScene& scene) {
    std::vector<verify::SurfaceTriangle> triangles;
    for (const formats::GltfScene::Placed& placed : scene.placedMeshes()) {
        const formats::MeshAttribute *positions = placed.mesh->find("POSITION"), *uvs = placed.mesh->find("TEXCOORD_1"),
                                     *normals = placed.mesh->find("NORMAL");
        if (positions == nullptr || uvs == nullptr) continue;
        const glm::dmat3 worldFromMesh(placed.worldFromMesh), normalMatrix = glm::transpose(glm::inverse(worldFromMesh));
        const bool isMirrored = glm::determinant(worldFromMesh) < 0;
        for (std::size_t triangle = 0; triangle < placed.mesh->triangleCount(); ++triangle) {
            verify::SurfaceTriangle& made = triangles.emplace_back(verify::SurfaceTriangle{});
            for (std::size_t corner = 0; corner < 3; ++corner) {
                // glTF: the front of a triangle stays the front under a mirror, so the order of its corners is reversed.
                const std::uint32_t vertex = placed.mesh->indices[3 * triangle + (isMirrored ? 2 - corner : corner)];
                made.position[corner] = glm::dvec3(placed.worldFromMesh * glm::dvec4(positions->at(vertex), 1));
                made.uv[corner] = glm::dvec2(uvs->at(vertex));
                if (normals != nullptr) made.normal[corner] = glm::vec3(glm::normalize(normalMatrix * normals->at(vertex)));
            }
        }
    }
    return triangles;
}

void turn(std::span<verify::SurfaceTriangle> triangles, const formats::BakeAxes& axes) {
    if (axes.isIdentity()) return;
    for (verify::SurfaceTriangle& triangle : triangles) {
        for (glm::dvec3& position : triangle.position) position = axes(position);
        for (glm::vec3& normal : triangle.normal) normal = glm::vec3(axes(glm::dvec3(normal)));
        if (axes.isRotation()) continue;
        std::swap(triangle.position[1], triangle.position[2]);
        std::swap(triangle.normal[1], triangle.normal[2]);
        std::swap(triangle.uv[1], triangle.uv[2]);
    }
}

std::optional<MeshPlace> placeAt(std::span<const verify::SurfaceTriangle> triangles, const glm::dvec2& uv, const glm::dvec2& size) {
    const verify::SurfaceTriangle* nearest = nullptr;
    glm::dvec2 nearestUv(0);
    double least = 1;  // [texels squared]
    for (const verify::SurfaceTriangle& triangle : triangles) {
        const auto weights = weightsAt(triangle.uv, uv);
        if (!weights) continue;
        if (isInside(*weights)) {
            if (auto place = placeOn(triangle, *weights, size)) return place;
            continue;
        }
        const glm::dvec2 on = nearestOf(triangle.uv, uv), away = (on - uv) * size;
        if (const double distance = glm::dot(away, away); distance < least) {
            least = distance;
            nearest = &triangle;
            nearestUv = on;
        }
    }
    return nearest != nullptr ? placeOn(*nearest, *weightsAt(nearest->uv, nearestUv), size) : std::nullopt;
}

MeshCamera cameraInFrontOf(std::span<const verify::SurfaceTriangle> triangles, const MeshPlace& place, double radius, double& distance) {
    constexpr double kSlope = 0.5, kFree = 0.95;
    MeshCamera camera;
    camera.slope = kSlope;
    distance = radius / kSlope;
    // The place's own triangle, and those that touch it there, are not in the way.
    const double skipped = 1e-3 * place.texelSide;
    const glm::dvec3 start = place.position + skipped * place.normal;
    for (const verify::SurfaceTriangle& triangle : triangles)
        distance = std::min(distance, kFree * (skipped + meets(start, place.normal, triangle)));
    camera.eye = place.position + distance * place.normal;
    camera.forward = -place.normal;
    const glm::dvec3 vertical = std::abs(place.normal.y) < 0.99 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, -1);
    camera.right = glm::normalize(glm::cross(camera.forward, vertical));
    camera.up = glm::cross(camera.right, camera.forward);
    camera.nearest = 1e-3 * distance;
    return camera;
}

formats::Image<glm::dvec2> rasterized(std::span<const verify::SurfaceTriangle> triangles, const MeshCamera& camera, int side) {
    Canvas canvas(side);
    for (const verify::SurfaceTriangle& triangle : triangles) {
        std::array<Corner, 3> corners;
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec3 to = triangle.position[i] - camera.eye;
            corners[i] = {{glm::dot(to, camera.right), glm::dot(to, camera.up), glm::dot(to, camera.forward)}, triangle.uv[i]};
        }
        const std::vector<Corner> polygon = clipped(corners, camera.nearest);
        for (std::size_t i = 2; i < polygon.size(); ++i) canvas.draw(polygon[0], polygon[i - 1], polygon[i], camera.slope);
    }
    return canvas.take();
}

}  // namespace lightcook::pipeline
