#include "verify/light_map/kernel_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <numbers>

namespace lightcook::verify {

namespace {

using lighting::ShBands;
using lighting::ShDouble;

constexpr std::size_t kBands = 3;
/// Places of the coefficients of order 1 and 2 of each band: cosine, sine, order.
struct OrderPair {
    std::size_t cosine, sine, band;
    double order;
};
constexpr std::array<OrderPair, 3> kPairs = {{{3, 1, 1, 1}, {7, 5, 2, 1}, {8, 4, 2, 2}}};

/// Lengths of the bands of exit radiance at any normal.
constexpr ShBands kExitLengths = {lighting::kShConstant, lighting::kShLinear * 2 / 3, 2 * lighting::kShZonal / 4};

/// Returns a kernel of the x-z plane, turned about z.
ShDouble turned(const ShDouble& profile, double azimuth) {
    ShDouble out = profile;
    for (const OrderPair& pair : kPairs) {
        out[pair.cosine] = std::cos(pair.order * azimuth) * profile[pair.cosine];
        out[pair.sine] = std::sin(pair.order * azimuth) * profile[pair.cosine];
    }
    return out;
}
/// Returns the derivative of turned() by the azimuth.
ShDouble turning(const ShDouble& profile, double azimuth) {
    ShDouble out{};
    for (const OrderPair& pair : kPairs) {
        out[pair.cosine] = -pair.order * std::sin(pair.order * azimuth) * profile[pair.cosine];
        out[pair.sine] = pair.order * std::cos(pair.order * azimuth) * profile[pair.cosine];
    }
    return out;
}
/// Returns the lengths of order^power times the parts of a profile that an azimuth turns.
ShBands turnedLengths(const ShDouble& profile, int power) {
    ShBands squares{};
    for (const OrderPair& pair : kPairs) {
        const double part = std::pow(pair.order, power) * profile[pair.cosine];
        squares[pair.band] += part * part;
    }
    return {0, std::sqrt(squares[1]), std::sqrt(squares[2])};
}

ShDouble exitProfile(double angle) {
    ShDouble out = lighting::evaluateBasis(glm::dvec3(std::sin(angle), 0, std::cos(angle)));
    for (std::size_t i = 0; i < out.size(); ++i) out[i] *= i == 0 ? 1.0 : i < 4 ? 2.0 / 3 : 1.0 / 4;
    return out;
}
ShDouble exitSlope(double angle) {
    const double s = std::sin(angle), c = std::cos(angle);
    ShDouble out{};
    out[2] = -2.0 / 3 * lighting::kShLinear * s;
    out[3] = 2.0 / 3 * lighting::kShLinear * c;
    out[6] = -0.25 * 6 * lighting::kShZonal * s * c;
    out[7] = 0.25 * lighting::kShProduct * (c * c - s * s);
    out[8] = 0.25 * 2 * lighting::kShDifference * s * c;
    return out;
}

/// Returns the lengths of a - b.
ShBands distance(const ShDouble& a, const ShDouble& b) {
    ShDouble out;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = a[i] - b[i];
    return lighting::bandLengths(out);
}
void raise(ShBands& largest, const ShBands& lengths) {
    for (std::size_t l = 0; l < kBands; ++l) largest[l] = std::max(largest[l], lengths[l]);
}
ShBands sumOf(const ShBands& a, const ShBands& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

}  // namespace

int KernelTree::addDiffuse(double low, double high, int depth) {
    constexpr int kDepth = 6;
    const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
    ProfileRange range;
    range.centre = exitProfile(middle);
    range.tangents[0] = exitSlope(middle);
    range.angle = middle;
    range.halfAngle = half;
    for (double& value : range.tangents[0]) value *= half;
    for (std::size_t l = 0; l < kBands; ++l) range.radius[l] = 0.5 * half * half * static_cast<double>(l * l) * kExitLengths[l];
    const auto index = ranges_.size();
    ranges_.push_back(range);
    if (half > 0 && depth < kDepth) {
        const int first = addDiffuse(low, middle, depth + 1), second = addDiffuse(middle, high, depth + 1);
        ranges_[index].first = first;
        ranges_[index].second = second;
    }
    return static_cast<int>(index);
}

KernelTree KernelTree::diffuse(double tilt) {
    KernelTree tree;
    tree.addDiffuse(0, tilt * std::numbers::pi / 180, 0);
    return tree;
}

/// Kernels at any place of the grid, and what lies between.
struct KernelTree::SpecularGrid {
    const ScannedKernels& scanned;
    double lowF0, highF0;
    std::vector<ShBands> between;  ///< [end of F0][roughness][view]

    SpecularGrid(const LightMapShading& shading, const ScannedKernels& kernels)
        : scanned(kernels), lowF0(std::ranges::min(shading.f0)), highF0(std::ranges::max(shading.f0)) {
        for (const double f0 : {lowF0, highF0})
            for (int r = 0; r < scanned.roughnessCount(); ++r)
                for (int v = 0; v < ScannedKernels::kViews; ++v) between.push_back(scanned.between(r, v, f0));
    }
    /// place  view, roughness [steps of the grid], F0
    ShDouble at(const glm::dvec3& place) const {
        const int v = std::min(static_cast<int>(place.x), ScannedKernels::kViews - 2),
                  r = std::clamp(static_cast<int>(place.y), 0, std::max(scanned.roughnessCount() - 2, 0));
        const double x = place.x - v, y = place.y - r;
        ShDouble out{};
        for (int corner = 0; corner < 4; ++corner) {
            const double weight = (corner % 2 == 0 ? 1 - x : x) * (corner / 2 == 0 ? 1 - y : y);
            if (weight == 0) continue;
            const ShDouble kernel = kernelAtF0(scanned.at(r + corner / 2, v + corner % 2), place.z);
            for (std::size_t i = 0; i < out.size(); ++i) out[i] += weight * kernel[i];
        }
        return out;
    }
    /// Returns the lengths of what may lie between the grid points around a box. Second differences are linear in F0, so that their lengths
    /// are at most linear.
    ShBands betweenOf(const glm::dvec3& low, const glm::dvec3& high) const {
        const auto count = static_cast<std::size_t>(scanned.roughnessCount() * ScannedKernels::kViews);
        ShBands largest{};
        for (int r = static_cast<int>(low.y); r <= static_cast<int>(std::ceil(high.y)); ++r)
            for (int v = static_cast<int>(low.x); v <= static_cast<int>(std::ceil(high.x)); ++v)
                for (const double f0 : {low.z, high.z}) {
                    const auto at = static_cast<std::size_t>(r * ScannedKernels::kViews + v);
                    const double part = highF0 > lowF0 ? (f0 - lowF0) / (highF0 - lowF0) : 0;
                    for (std::size_t l = 0; l < kBands; ++l)
                        largest[l] = std::max(largest[l], (1 - part) * between[at][l] + part * between[count + at][l]);
                }
        return largest;
    }
    double roughness(double place) const {
        const int r = std::clamp(static_cast<int>(place), 0, std::max(scanned.roughnessCount() - 2, 0));
        if (scanned.roughnessCount() == 1) return scanned.roughness(0);
        return std::lerp(scanned.roughness(r), scanned.roughness(r + 1), place - r);
    }
};

namespace {

/// Returns the ends of an interval and the whole numbers between them.
std::vector<double> stationsOf(double low, double high) {
    std::vector<double> out = {low};
    const double first = std::floor(low) + 1;
    for (int i = 0; first + i < high; ++i) out.push_back(first + i);
    if (high > low) out.push_back(high);
    return out;
}
double sumOfBands(const ShBands& bands) {
    return bands[0] + bands[1] + bands[2];
}

}  // namespace

ProfileRange KernelTree::specularRange(const SpecularGrid& grid, const glm::dvec3& low, const glm::dvec3& high) {
    ProfileRange range;
    const glm::dvec3 middle = 0.5 * (low + high);
    range.centre = grid.at(middle);
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 first = middle, last = middle;
        first[axis] = low[axis];
        last[axis] = high[axis];
        const ShDouble before = grid.at(first), after = grid.at(last);
        for (std::size_t i = 0; i < before.size(); ++i) range.tangents[static_cast<std::size_t>(axis)][i] = 0.5 * (after[i] - before[i]);
    }
    const glm::dvec3 half = 0.5 * (high - low);
    for (const double r : stationsOf(low.y, high.y))
        for (const double v : stationsOf(low.x, high.x))
            for (const double f0 : {low.z, high.z}) {
                ShDouble affine = range.centre;
                const glm::dvec3 off = glm::dvec3(v, r, f0) - middle;
                for (int axis = 0; axis < 3; ++axis)
                    for (std::size_t i = 0; i < affine.size(); ++i)
                        affine[i] += half[axis] > 0 ? off[axis] / half[axis] * range.tangents[static_cast<std::size_t>(axis)][i] : 0;
                raise(range.radius, distance(grid.at({v, r, f0}), affine));
            }
    range.radius = sumOf(range.radius, grid.betweenOf(low, high));
    range.angle = ScannedKernels::viewAngle(middle.x);
    range.m = grid.roughness(middle.y);
    range.f0 = middle.z;
    return range;
}

int KernelTree::addSpecular(const SpecularGrid& grid, const glm::dvec3& low, const glm::dvec3& high, double brightest) {
    // Ranges that vary less than this, relative to their own length or to a fifth of that of the brightest, are not cut.
    constexpr double kAlike = 0.1, kOfBrightest = 0.2;
    constexpr double kFinest = 0.3;  ///< of the grid's steps
    const ProfileRange range = specularRange(grid, low, high);
    const auto index = ranges_.size();
    ranges_.push_back(range);
    std::array<double, 3> widths{};
    for (std::size_t axis = 0; axis < 3; ++axis) widths[axis] = sumOfBands(lighting::bandLengths(range.tangents[axis]));
    const double size = std::max(sumOfBands(lighting::bandLengths(range.centre)), kOfBrightest * brightest);
    if (widths[0] + widths[1] + widths[2] + sumOfBands(range.radius) <= kAlike * size) return static_cast<int>(index);
    // Cuts through several steps of the grid are at a grid point, so that kernels are multilinear in the smallest boxes.
    for (int axis = 0; axis < 2; ++axis) {
        const double steps = high[axis] - low[axis];
        if (steps > 1) widths[static_cast<std::size_t>(axis)] += sumOfBands(range.radius) * steps / (steps + 1);
        if (steps < kFinest) widths[static_cast<std::size_t>(axis)] = 0;
    }
    const auto widest = std::max_element(widths.begin(), widths.end());
    if (!(*widest > 0.2 * kAlike * size)) return static_cast<int>(index);
    const auto axis = static_cast<int>(widest - widths.begin());
    double cut = 0.5 * (low[axis] + high[axis]);
    if (axis < 2 && high[axis] - low[axis] > 1) cut = std::round(cut);
    glm::dvec3 lowHalf = high, highHalf = low;
    lowHalf[axis] = highHalf[axis] = cut;
    const int first = addSpecular(grid, low, lowHalf, brightest), second = addSpecular(grid, highHalf, high, brightest);
    ranges_[index].first = first;
    ranges_[index].second = second;
    return static_cast<int>(index);
}

KernelTree KernelTree::specular(const LightMapShading& shading, const ScannedKernels& scanned) {
    KernelTree tree;
    tree.isSpecular_ = true;
    const SpecularGrid grid(shading, scanned);
    double brightest = 0;
    for (int r = 0; r < scanned.roughnessCount(); ++r)
        for (int v = 0; v < ScannedKernels::kViews; ++v)
            brightest = std::max(brightest, sumOfBands(lighting::bandLengths(kernelAtF0(scanned.at(r, v), grid.highF0))));
    tree.addSpecular(grid, {0, 0, grid.lowF0}, {ScannedKernels::kViews - 1, scanned.roughnessCount() - 1, grid.highF0}, brightest);
    return tree;
}

KernelCell KernelTree::cell(int index, double azimuth, double half) const {
    const ProfileRange& from = range(index);
    KernelCell cell;
    cell.profileRadius = from.radius;
    const std::size_t tangents = cell.tangents = isSpecular_ ? kProfileTangents : 1;
    if (half > kNarrow) {
        cell.centre = from.centre;
        cell.alongProfile = from.tangents;
        for (const OrderPair& pair : kPairs) cell.centre[pair.cosine] = 0;
        cell.azimuthRadius = turnedLengths(from.centre, 0);
        for (std::size_t i = 0; i < tangents; ++i) {
            for (const OrderPair& pair : kPairs) cell.alongProfile[i][pair.cosine] = 0;
            cell.azimuthRadius = sumOf(cell.azimuthRadius, turnedLengths(from.tangents[i], 0));
        }
    } else {
        cell.centre = turned(from.centre, azimuth);
        cell.alongAzimuth = turning(from.centre, azimuth);
        for (double& value : cell.alongAzimuth) value *= half;
        const ShBands second = turnedLengths(from.centre, 2);
        for (std::size_t l = 0; l < kBands; ++l) cell.azimuthRadius[l] = 0.5 * half * half * second[l];
        for (std::size_t i = 0; i < tangents; ++i) {
            cell.alongProfile[i] = turned(from.tangents[i], azimuth);
            const ShBands mixed = turnedLengths(from.tangents[i], 1);
            for (std::size_t l = 0; l < kBands; ++l) cell.azimuthRadius[l] += half * mixed[l];
        }
    }
    cell.lengths = sumOf(lighting::bandLengths(from.centre), from.radius);
    for (std::size_t i = 0; i < tangents; ++i) cell.lengths = sumOf(cell.lengths, lighting::bandLengths(from.tangents[i]));
    if (isSpecular_) return cell;
    cell.isDiffuse = true;
    cell.lengths = kExitLengths;
    const double sine = std::sin(from.angle);
    cell.normal = {sine * std::cos(azimuth), sine * std::sin(azimuth), std::cos(from.angle)};
    cell.profileAngle = from.halfAngle;
    cell.azimuthAngle = sine * half;
    return cell;
}

CoarseKernels CoarseKernels::diffuse(const KernelTree& tree) {
    constexpr double kLargestTurn = 0.07;
    CoarseKernels out;
    const auto visit = [&](auto&& self, int index) -> void {
        const ProfileRange& range = tree.range(index);
        const ShBands along = lighting::bandLengths(range.tangents[0]);
        if (along[1] <= kLargestTurn || range.isLeaf()) return out.addTurned(range.centre, sumOf(range.radius, along));
        self(self, range.first);
        self(self, range.second);
    };
    visit(visit, 0);
    out.lengths = kExitLengths;
    return out;
}

CoarseKernels CoarseKernels::specular(const KernelTree& tree) {
    constexpr double kAlike = 0.9;  ///< of the length of band 0
    double brightest = 0;
    const auto largestSize = [&](const ProfileRange& range) {
        double size = range.centre[0] + range.radius[0];
        for (const ShDouble& tangent : range.tangents) size += std::abs(tangent[0]);
        return size;
    };
    for (std::size_t i = 0; i < tree.size(); ++i)
        if (tree.range(static_cast<int>(i)).isLeaf()) brightest = std::max(brightest, largestSize(tree.range(static_cast<int>(i))));
    // A ball around kernels of a leaf, each times the factor that makes it as bright as the brightest.
    struct Ball {
        ShDouble centre;
        ShBands radius;
    };
    const auto ballOf = [&](const ProfileRange& range) {
        const double half = largestSize(range) - range.centre[0], low = std::max(range.centre[0] - half, 1e-9),
                     high = range.centre[0] + half;
        const double factor = 0.5 * brightest * (1 / low + 1 / high), spread = 0.5 * brightest * (1 / low - 1 / high);
        Ball ball{range.centre, range.radius};
        for (const ShDouble& tangent : range.tangents) ball.radius = sumOf(ball.radius, lighting::bandLengths(tangent));
        const ShBands lengths = sumOf(lighting::bandLengths(range.centre), ball.radius);
        for (double& value : ball.centre) value *= factor;
        for (std::size_t l = 0; l < kBands; ++l) ball.radius[l] = factor * ball.radius[l] + spread * lengths[l];
        return ball;
    };
    std::vector<Ball> balls;
    ShBands norms{};
    for (std::size_t i = 0; i < tree.size(); ++i) {
        if (!tree.range(static_cast<int>(i)).isLeaf()) continue;
        const Ball ball = ballOf(tree.range(static_cast<int>(i)));
        raise(norms, sumOf(lighting::bandLengths(ball.centre), ball.radius));
        Ball* nearest = nullptr;
        ShBands least{};
        for (Ball& each : balls) {
            const ShBands reach = sumOf(distance(ball.centre, each.centre), ball.radius);
            if (nearest != nullptr && reach[1] + reach[2] >= least[1] + least[2]) continue;
            nearest = &each;
            least = reach;
        }
        if (nearest == nullptr || least[1] + least[2] > kAlike * brightest * (1 + lighting::bandLengths(ball.centre)[2] / brightest))
            balls.push_back(ball);
        else
            raise(nearest->radius, least);
    }
    CoarseKernels out;
    for (const Ball& ball : balls) out.addTurned(ball.centre, ball.radius);
    out.lengths = norms;
    return out;
}

void CoarseKernels::addTurned(const ShDouble& profile, const ShBands& radius) {
    constexpr int kSectors = 12;
    constexpr double kHalf = std::numbers::pi / kSectors;
    const ShBands first = turnedLengths(profile, 1);
    for (int sector = 0; sector < kSectors; ++sector) {
        centres.push_back(turned(profile, 2 * kHalf * (sector + 0.5)));
        ShBands reach = radius;
        for (std::size_t l = 0; l < kBands; ++l) {
            reach[l] += kHalf * first[l];
        }
        radii.push_back(reach);
        // Without an axis, one is enough.
        if (first[1] + first[2] < 1e-9) break;
    }
}

}  // namespace lightcook::verify
