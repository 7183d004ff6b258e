#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "lighting/cube.h"
#include "verify/cubemap.h"

namespace lightcook::verify {
namespace {

using formats::Environment;
using formats::Image;

/// A texel of the source under one of the result, along one axis.
struct Part {
    int texel;
    double share;  ///< of the texel's extent that lies under it
};

/// Returns the texels of `count` that lie under each of `reduced`, where edge(i) is the position of the edge before texel i. A position
/// between two edges of the source counts by the same measure.
template <class Edge>
std::vector<std::vector<Part>> partsOf(int count, int reduced, Edge edge) {
    std::vector<std::vector<Part>> parts(static_cast<std::size_t>(reduced));
    for (int i = 0; i < reduced; ++i) {
        const double begin = static_cast<double>(i) * count / reduced, end = static_cast<double>(i + 1) * count / reduced;
        for (int texel = static_cast<int>(begin); texel < std::min(std::ceil(end), static_cast<double>(count)); ++texel) {
            const double low = edge(std::max<double>(begin, texel)), high = edge(std::min<double>(end, texel + 1));
            const double share = (high - low) / (edge(texel + 1.0) - edge(texel));
            if (share > 0) parts[static_cast<std::size_t>(i)].push_back({texel, share});
        }
    }
    return parts;
}

/// Sets a rectangle of a result to means. Columns and rows are those of the rectangle's part of the source, whose first row is firstRow.
/// weight(x, y)  solid angle of a texel of the source
template <class Weight>
void reduceInto(const Image<glm::vec3>& source, int firstRow, const std::vector<std::vector<Part>>& columns,
                const std::vector<std::vector<Part>>& rows, Weight weight, Image<glm::vec3>& out, int outRow) {
    for (std::size_t y = 0; y < rows.size(); ++y)
        for (std::size_t x = 0; x < columns.size(); ++x) {
            glm::dvec3 sum(0);
            double weights = 0;
            for (const Part& row : rows[y])
                for (const Part& column : columns[x]) {
                    const double part = row.share * column.share * weight(column.texel, row.texel);
                    sum += part * glm::dvec3(source.at(column.texel, firstRow + row.texel));
                    weights += part;
                }
            out.at(static_cast<int>(x), outRow + static_cast<int>(y)) = glm::vec3(sum / weights);
        }
}

}  // namespace

std::optional<Environment> reducedEnvironment(const Environment& environment, double width) {
    const Image<glm::vec3>& source = environment.texels;
    const auto straight = [](double position) { return position; };
    Environment out;
    out.projection = environment.projection;
    if (environment.projection == Environment::Projection::Equirectangular) {
        const int height = source.height(), reduced = static_cast<int>(std::ceil(std::numbers::pi / width));
        if (reduced >= height) return std::nullopt;
        const auto sine = [&](double row) { return -std::cos(row * std::numbers::pi / height); };
        out.texels = Image<glm::vec3>(2 * reduced, reduced);
        reduceInto(
            source, 0, partsOf(2 * height, 2 * reduced, straight), partsOf(height, reduced, sine),
            [&](int, int y) { return sine(y + 1) - sine(y); }, out.texels, 0);
        return out;
    }
    const int size = source.width(), reduced = static_cast<int>(std::ceil(2 / width));
    if (reduced >= size) return std::nullopt;
    out.texels = Image<glm::vec3>(reduced, 6 * reduced);
    const auto parts = partsOf(size, reduced, straight);
    for (int face = 0; face < 6; ++face)
        reduceInto(
            source, face * size, parts, parts, [&](int x, int y) { return lighting::cubeTexelSolidAngle(x, y, size); }, out.texels,
            face * reduced);
    return out;
}

}  // namespace lightcook::verify
