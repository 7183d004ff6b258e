// Bounds of local errors of light maps, over the whole range of floats, searched against long double.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "tests/compress/synthetic_light_map.h"
#include "tests/lighting/real_sh.h"
#include "tests/lighting/worst_search.h"
#include "tests/verify/cooked_light_map.h"
#include "tests/verify/itp_truth.h"
#include "verify/error/visible_any_light.h"
#include "verify/light_map/bound.h"
#include "verify/light_map/kernel_cells.h"
#include "verify/light_map/scanned_kernels.h"
#include "verify/light_map/visible_grid.h"
#include "verify/light_map/visible_search.h"

namespace lightcook {
namespace {

using test::Real;
using test::SearchBudget;
using test::SearchRange;
using Kind = SearchRange::Kind;
using Input = std::vector<double>;

/// Shades coefficients towards n.
Real shaded(const test::RealSh& k, const lighting::ShBands& bands, const std::array<Real, 3>& n) {
    const test::RealSh basis = test::realBasis(n[0], n[1], n[2]);
    Real sum = 0;
    for (std::size_t i = 0; i < k.size(); ++i)
        sum += static_cast<Real>(bands[static_cast<std::size_t>(lighting::kShBand[i])]) * k[i] * basis[i];
    return sum;
}

constexpr std::size_t kPairs = 2;
/// Two pairs of error and reference, a direction, the weight of the first, two responses in one, and a limit.
std::vector<SearchRange> pairRanges(double low, double high) {
    std::vector<SearchRange> ranges(18 * kPairs, {low, high, Kind::Signed});
    ranges.insert(ranges.end(), 3, {1e-6, 1, Kind::Signed});  // direction
    ranges.push_back({0, 1, Kind::Linear});                   // weight of the first pair
    ranges.insert(ranges.end(), 2, {1e-3, 1});                // factors of bands 1 and 2
    ranges.push_back({1e-9, 1e9});                            // floor, as a multiple of that of the program
    return ranges;
}
struct Lights {
    std::array<verify::ErrorPair, kPairs> pairs;
    std::array<Real, 3> n;
    Real error, reference;  ///< of a mean of the pairs
    verify::Response response;
    double floor;
};
Lights lightsOf(const Input& in, bool hasFloor) {
    Lights out;
    for (std::size_t j = 0; j < kPairs; ++j)
        for (std::size_t i = 0; i < 9; ++i) {
            out.pairs[j].error[i] = static_cast<float>(in[18 * j + i]);
            out.pairs[j].reference[i] = static_cast<float>(in[18 * j + 9 + i]);
        }
    const std::size_t at = 18 * kPairs;
    const Real x = static_cast<Real>(in[at]), y = static_cast<Real>(in[at + 1]), z = static_cast<Real>(in[at + 2]) + 1e-7L,
               length = std::sqrt(x * x + y * y + z * z);
    out.n = {x / length, y / length, z / length};
    out.response.bands = {1, in[at + 4], in[at + 5]};
    out.floor = lighting::kLocalErrorFloor * (hasFloor ? 1 : in[at + 6]);
    std::array<Real, 9> error, reference;
    for (std::size_t i = 0; i < 9; ++i) {
        const Real first = static_cast<Real>(in[at + 3]), second = 1 - first;
        error[i] = first * static_cast<Real>(out.pairs[0].error[i]) + second * static_cast<Real>(out.pairs[1].error[i]);
        reference[i] = first * static_cast<Real>(out.pairs[0].reference[i]) + second * static_cast<Real>(out.pairs[1].reference[i]);
    }
    out.error = shaded(error, out.response.bands, out.n);
    out.reference = shaded(reference, out.response.bands, out.n);
    return out;
}
Real localErrorOf(const Lights& lights) {
    return std::abs(lights.error) / (std::abs(lights.reference) + static_cast<Real>(lights.floor));
}
void expectBound(const SearchBudget& budget, double low, double high, bool hasFloor) {
    test::expectHolds("localErrorBound", pairRanges(low, high), budget, [=](const Input& in) {
        const Lights lights = lightsOf(in, hasFloor);
        const double bound = verify::localErrorBound(lights.pairs, {&lights.response, 1}, lights.floor, {});
        return lights.error == 0 ? Real(0) : localErrorOf(lights) / static_cast<Real>(bound);
    });
}
/// A limit that is below the error somewhere is not proven.
void expectTest(const SearchBudget& budget, double low, double high) {
    test::expectHolds("cannotExceed", pairRanges(low, high), budget, [](const Input& in) {
        const Lights lights = lightsOf(in, true);
        const Real error = localErrorOf(lights);
        // No limit below the error may pass; the largest that does counts.
        for (const double share : {0.9999999999, 0.999999, 0.999, 0.9, 0.5, 0.1})
            if (verify::cannotExceed(lights.pairs, {&lights.response, 1}, lights.floor, {}, share * static_cast<double>(error)))
                return 2 - static_cast<Real>(share);
        // None: how near the bound is.
        const double bound = verify::localErrorBound(lights.pairs, {&lights.response, 1}, lights.floor, {});
        return lights.error == 0 ? Real(0) : error / static_cast<Real>(bound) * 0.999L;
    });
}

/// Bounds of visible errors under many kernels: two control vectors of reference and error, a kernel, and the weight of the first.
class VisibleBounds {
public:
    VisibleBounds(double black, verify::LightMapShading shading)
        : shading_(std::move(shading)),
          scanned_(shading_),
          viewing_{{36, black}},
          metric_(viewing_, 1),
          anyLight_(metric_),
          tree_(shading_.specular ? verify::KernelTree::specular(shading_, scanned_) : verify::KernelTree::diffuse(kTilt)),
          grids_{gridOf(1), gridOf(2)},
          grid_(metric_, anyLight_, grids_) {}

    /// brightness  of the light
    /// error       over the light
    static std::vector<SearchRange> ranges(const SearchRange& brightness, const SearchRange& error) {
        std::vector<SearchRange> out(kCount, {1e-6, 1, Kind::Signed});
        out.insert(out.end(), 2, {0, 1, Kind::Linear});   // tilt or view, weight
        out.insert(out.end(), 2, {-1, 1, Kind::Linear});  // azimuth, place in a cell
        out.insert(out.end(), {brightness, error});
        out.insert(out.end(), 4, {0, 1, Kind::Linear});    // a cell of kernels, and its width; roughness and F0
        out.insert(out.end(), 11, {-1, 1, Kind::Linear});  // place in a cell of specular kernels, and what is beside it
        return out;
    }
    Real gridRatio(const Input& in, bool isFine) {
        const Real azimuth = static_cast<Real>(in[kCount + 2]) * kPi;
        const test::RealSh kernel =
            shading_.specular ? specularKernel(in, azimuth) : diffuseKernel(static_cast<Real>(in[kCount]) * kTilt * kPi / 180, azimuth);
        return truthOf(in, kernel) / static_cast<Real>(grid_.bound(lightOf(in), 0, isFine));
    }
    Real cellRatio(const Input& in) const {
        const int index = static_cast<int>(in[kCount + 6] * (static_cast<double>(tree_.size()) - 1));
        const double half = in[kCount + 7] * in[kCount + 7] * static_cast<double>(kPi), azimuth = in[kCount + 2];
        const verify::KernelCell cell = tree_.cell(index, azimuth, half);
        const double bound = verify::VisibleSearch(metric_, tree_).cellBound(lightOf(in), cell);
        const verify::ProfileRange& range = tree_.range(index);
        const test::RealSh kernel =
            shading_.specular ? kernelOfCell(in, cell)
                              : diffuseKernel(static_cast<Real>(range.angle) +
                                                  (2 * static_cast<Real>(in[kCount]) - 1) * static_cast<Real>(range.halfAngle),
                                              static_cast<Real>(azimuth) + static_cast<Real>(in[kCount + 3]) * static_cast<Real>(half));
        return truthOf(in, kernel) / static_cast<Real>(bound);
    }

private:
    static constexpr double kTilt = 60;
    static constexpr Real kPi = 3.14159265358979323846264338327950288L;
    static constexpr std::size_t kCount = 2 * 2 * 27;
    verify::KernelGrid gridOf(int fineness) const {
        return shading_.specular ? verify::KernelGrid::specular(shading_, scanned_, fineness)
                                 : verify::KernelGrid::diffuse(kTilt, fineness);
    }
    static float coefficient(const Input& in, std::size_t control, bool isError, std::size_t c, std::size_t i) {
        const double bright = in[kCount + 4] * (isError ? in[kCount + 5] : 1);
        return static_cast<float>(bright * in[54 * control + (isError ? 27 : 0) + 9 * c + i]);
    }
    static verify::CellLight lightOf(const Input& in) {
        verify::CellLight light;
        for (std::size_t control = 0; control < 2; ++control) {
            std::array<lighting::Sh, 3> reference, error, found;
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t i = 0; i < 9; ++i) {
                    reference[c][i] = coefficient(in, control, false, c, i);
                    error[c][i] = coefficient(in, control, true, c, i);
                    found[c][i] = reference[c][i] + error[c][i];
                }
            light.references.add(reference);
            light.errors.add(error);
            light.found.add(found);
        }
        return light;
    }
    static test::RealSh diffuseKernel(Real angle, Real azimuth) {
        test::RealSh out = test::realBasis(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle));
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] *= static_cast<Real>(lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[i])]);
        return out;
    }
    /// Any view, roughness and F0 of the shading.
    test::RealSh specularKernel(const Input& in, Real azimuth) const {
        const double NoV = std::max(1e-3, std::cos(0.5 * std::numbers::pi * in[kCount])), low = std::ranges::min(shading_.m),
                     m = low * std::pow(std::ranges::max(shading_.m) / low, in[kCount + 8]);
        const lighting::ShDouble profile =
            verify::kernelAtF0(verify::specularKernelAt(NoV, m, shading_.lobe, 64),
                               std::lerp(std::ranges::min(shading_.f0), std::ranges::max(shading_.f0), in[kCount + 9]));
        test::RealSh out;
        std::ranges::copy(profile, out.begin());
        for (const auto& [cosine, sine, order] : {std::array<std::size_t, 3>{3, 1, 1}, {7, 5, 1}, {8, 4, 2}}) {
            out[sine] = std::sin(static_cast<Real>(order) * azimuth) * out[cosine];
            out[cosine] *= std::cos(static_cast<Real>(order) * azimuth);
        }
        return out;
    }
    /// Any kernel that a cell says it has.
    static test::RealSh kernelOfCell(const Input& in, const verify::KernelCell& cell) {
        auto next = [&, at = kCount + 10]() mutable { return static_cast<Real>(in[at++]); };
        test::RealSh out, beside;
        const std::array<Real, 3> along = {next(), static_cast<Real>(in[kCount + 3]), 2 * static_cast<Real>(in[kCount + 1]) - 1};
        const Real turn = next();
        for (std::size_t i = 0; i < out.size(); ++i) {
            out[i] = static_cast<Real>(cell.centre[i]) + turn * static_cast<Real>(cell.alongAzimuth[i]);
            for (std::size_t k = 0; k < along.size(); ++k) out[i] += along[k] * static_cast<Real>(cell.alongProfile[k][i]);
            beside[i] = next();
        }
        std::array<Real, 3> lengths{};
        for (std::size_t i = 0; i < out.size(); ++i) lengths[static_cast<std::size_t>(lighting::kShBand[i])] += beside[i] * beside[i];
        for (std::size_t i = 0; i < out.size(); ++i) {
            const auto l = static_cast<std::size_t>(lighting::kShBand[i]);
            out[i] += static_cast<Real>(cell.profileRadius[l] + cell.azimuthRadius[l]) * beside[i] / std::max(1e-9L, std::sqrt(lengths[l]));
        }
        return out;
    }
    /// The visible error of a mean of the control vectors under a kernel.
    Real truthOf(const Input& in, const test::RealSh& kernel) const {
        const Real weights[2] = {static_cast<Real>(in[kCount + 1]), 1 - static_cast<Real>(in[kCount + 1])};
        std::array<Real, 3> x{}, y{};
        for (std::size_t c = 0; c < 3; ++c) {
            for (std::size_t i = 0; i < 9; ++i)
                for (std::size_t control = 0; control < 2; ++control) {
                    x[c] += kernel[i] * weights[control] * static_cast<Real>(coefficient(in, control, false, c, i));
                    y[c] += kernel[i] * weights[control] * static_cast<Real>(coefficient(in, control, true, c, i));
                }
            y[c] += x[c];
        }
        return verify::truthOf(x, y, viewing_);
    }

    verify::LightMapShading shading_;
    verify::ScannedKernels scanned_;
    verify::Viewing viewing_;
    verify::VisibleMetric metric_;
    verify::AnyLightBound anyLight_;
    verify::KernelTree tree_;
    verify::KernelGrids grids_;
    verify::GridBound grid_;
};
verify::LightMapShading diffuseShading() {
    verify::LightMapShading out;
    out.specular = false;
    return out;
}
/// Roughness and F0 of a scene that says nothing, and all that there are.
std::vector<verify::LightMapShading> specularShadings() {
    verify::LightMapShading usual, any = usual, one = usual;
    any.m = {0.01, 1};
    any.f0 = {0, 1};
    one.m = {0.3};
    one.f0 = {0.04};
    return {usual, any, one};
}
void expectVisibleBounds(const SearchBudget& budget, double black, const verify::LightMapShading& shading) {
    VisibleBounds bounds(black, shading);
    const std::string light = shading.specular ? " of specular light" : "";
    // The bound is the largest difference where light, or an error, is beyond the curve: also of light that a screen shows.
    for (const auto& ranges : {VisibleBounds::ranges({1e-30, 1e25}, {1e-12, 1e12}), VisibleBounds::ranges({1e-3, 10}, {1e-6, 0.3})}) {
        test::expectHolds("VisibleSearch::cellBound" + light, ranges, budget, [&](const Input& in) { return bounds.cellRatio(in); });
        test::expectHolds("GridBound, coarse" + light, ranges, budget, [&](const Input& in) { return bounds.gridRatio(in, false); });
        test::expectHolds("GridBound, fine" + light, ranges, budget, [&](const Input& in) { return bounds.gridRatio(in, true); });
    }
}

TEST(VisibleBoundNumbers, Bounds) {
    expectVisibleBounds({1500}, 0.5, diffuseShading());
}
TEST(VisibleBoundNumbers, SpecularBounds) {
    expectVisibleBounds({200}, 0.5, specularShadings()[0]);
}
TEST(VisibleBoundNumbersSoak, Bounds) {
    for (const double black : {0.005, 0.5, 100.0}) expectVisibleBounds(test::soakBudget(18), black, diffuseShading());
}
TEST(VisibleBoundNumbersSoak, SpecularBounds) {
    for (const double black : {0.005, 0.5, 100.0})
        for (const verify::LightMapShading& shading : specularShadings()) expectVisibleBounds(test::soakBudget(54), black, shading);
}
// ---- layouts

/// A map of lights and shadows in some unit, and what a layout makes of it.
struct ScaledMap {
    Real error;                   ///< of the exit radiance decoded in floats, RMS over texels and all normals, over that of the reference
    Real local;                   ///< largest local error over texels, channels and some normals
    verify::ErrorFigures stated;  ///< by the verifier, of diffuse light
};
ScaledMap scaledMap(formats::LightMapLayout id, float unit) {
    constexpr int kWidth = 24, kHeight = 16;
    formats::LightMapStrip strip = synthetic::makeBand(synthetic::Kind::Gradient, kWidth, 0, kHeight);
    for (lighting::ShRgb& sh : strip.sh.texels())
        for (glm::vec3& coefficient : sh) coefficient *= unit;
    const test::Cooked cooked = test::cook(std::move(strip), id, formats::Target::Bc, 0);
    ScaledMap out{0, 0, cooked.total().diffuse};
    Real errors = 0, references = 0;
    const auto layout = test::layoutOn(cooked);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            if (cooked.reference.covered.at(x, y) == 0) continue;
            const shaders::LcSh light = std::visit([&](const auto& each) { return test::lightOfTexel(cooked, each, x, y); }, layout);
            for (int c = 0; c < 3; ++c) {
                std::array<Real, 9> error, reference;
                for (std::size_t i = 0; i < 9; ++i) {
                    reference[i] = static_cast<Real>(cooked.reference.sh.at(x, y)[i][c]) / static_cast<Real>(cooked.key);
                    error[i] = static_cast<Real>(light.c[i][c]) / static_cast<Real>(cooked.key) - reference[i];
                    const Real band = static_cast<Real>(lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[i])]);
                    errors += band * band * error[i] * error[i];
                    references += band * band * reference[i] * reference[i];
                }
                for (int k = 0; k < 12; ++k) {
                    const glm::dvec3 d = lighting::fibonacciSphere(k, 12);
                    const std::array<Real, 3> n = {static_cast<Real>(d.x), static_cast<Real>(d.y), static_cast<Real>(d.z)};
                    out.local = std::max(out.local, std::abs(shaded(error, lighting::kExitRadianceBands, n)) /
                                                        (std::abs(shaded(reference, lighting::kExitRadianceBands, n)) + 0.02L));
                }
            }
        }
    out.error = std::sqrt(errors / references);
    return out;
}
/// In each unit, 2^first to 2^last, the bound holds, and the stated error is not much less than that of all normals. Prints the units in
/// which the layout errs as in the unit 1, by up to 30 % (blocks differ) and
/// 0.0001 more. Layouts that store halves in the unit of an engine hold fewer than the others.
void expectLayout(formats::LightMapLayout id, int first, int last, int step) {
    const std::string name(formats::info(id).name);
    const Real usual = scaledMap(id, 1).error;
    int lowest = first, highest = last;
    Real worstBound = 0, worstStated = 0;
    for (int exponent = first; exponent <= last; exponent += step) {
        const ScaledMap map = scaledMap(id, std::ldexp(1.37f, exponent));
        if (!(map.error <= 1.3L * usual + 1e-4L)) {
            if (exponent < 0) lowest = exponent + step;
            if (exponent > 0) highest = std::min(highest, exponent - step);
        }
        // Sampled normals are those of a hemisphere, and at places between texels.
        EXPECT_GE(static_cast<Real>(map.stated.relRms), 0.4L * map.error - 1e-6L) << name << ", unit 2^" << exponent;
        EXPECT_FALSE(std::isnan(map.error)) << name << ", unit 2^" << exponent;
        ASSERT_TRUE(map.stated.maxBound.has_value());
        EXPECT_LE(map.local, static_cast<Real>(*map.stated.maxBound) * (1 + 1e-6L)) << name << ", unit 2^" << exponent;
        worstBound = std::max(worstBound, map.local / static_cast<Real>(*map.stated.maxBound));
        worstStated = std::max(worstStated, map.error / (static_cast<Real>(map.stated.relRms) + 1e-6L));
    }
    const auto family = formats::info(id).family;
    if (family != formats::LightMapFamily::Godot && family != formats::LightMapFamily::Bakery) {
        EXPECT_LE(lowest, std::max(first, -41)) << name;
        EXPECT_EQ(highest, last) << name;
    }
    std::cout << name << ": error " << usual << ", units 2^" << lowest << " to 2^" << highest << "; bound " << worstBound << ", stated "
              << worstStated << '\n';
}

TEST(LayoutNumbers, StatedErrorsAndBoundsHoldInEveryUnit) {
    for (const auto layout : {formats::LightMapLayout::Ratio, formats::LightMapLayout::Hdr, formats::LightMapLayout::Halo3})
        expectLayout(layout, -40, 116, 52);
}
TEST(LayoutNumbersSoak, StatedErrorsAndBoundsHoldInEveryUnit) {
    for (const formats::LightMapLayout layout : test::directionalLayouts()) expectLayout(layout, -146, 120, 7);
}
TEST(LocalErrorNumbers, Bound) {
    expectBound({12000}, 1e-45, 3.4e38, true);
}
TEST(LocalErrorNumbers, Test) {
    expectTest({6000}, 1e-45, 3.4e38);
}
TEST(LocalErrorNumbersSoak, Bound) {
    expectBound(test::soakBudget(2), 1e-45, 3.4e38, true);
    expectBound(test::soakBudget(2), 1e-6, 1e6, false);
}
TEST(LocalErrorNumbersSoak, Test) {
    expectTest(test::soakBudget(2), 1e-45, 3.4e38);
    expectTest(test::soakBudget(2), 1e-6, 1e6);
}

}  // namespace
}  // namespace lightcook
