#include "lighting/area_specular.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "tests/soak/soak.h"

namespace lightcook::lighting {
namespace {

constexpr CookTorranceNormalization kEnergyForm = CookTorranceNormalization::Energy, kHalo3Form = CookTorranceNormalization::Halo3;
constexpr std::array<SpecularLobe, 4> kLobes = {SpecularLobe::Beckmann, SpecularLobe::Ggx, SpecularLobe::Phong, SpecularLobe::PhongPower};
constexpr long double kLongPi = 3.14159265358979323846264338327950288L;

/// C and D for 0, 2, 3, 6, 7, 8.
using Entries = std::array<long double, 12>;

Entries entriesOf(const AreaSpecularKernel& k) {
    return {k.c[0], k.c[2], k.c[3], k.c[6], k.c[7], k.c[8], k.d[0], k.d[2], k.d[3], k.d[6], k.d[7], k.d[8]};
}

/// Adaptive Gauss-Kronrod of twelve functions at once, in long double, to an absolute error.
template <class Function>
Entries adaptive(const Function& function, long double low, long double high, long double tolerance, int depth) {
    static constexpr std::array<long double, 8> kNodes = {0.991455371120812639206854697526329L, 0.949107912342758524526189684047851L,
                                                          0.864864423359769072789712788640926L, 0.741531185599394439863864773280788L,
                                                          0.586087235467691130294144691693013L, 0.405845151377397166906606412076961L,
                                                          0.207784955007898467600689403773245L, 0};
    static constexpr std::array<long double, 8> kKronrod = {0.022935322010529224963732008058970L, 0.063092092629978553290700663189204L,
                                                            0.104790010322250183839876322541518L, 0.140653259715525918745189590510238L,
                                                            0.169004726639267902826583426598550L, 0.190350578064785409913256402421014L,
                                                            0.204432940075298892414161999234649L, 0.209482141084727828012999174891714L};
    static constexpr std::array<long double, 4> kGauss = {0.129484966168869693270611432679082L, 0.279705391489276667901467771423780L,
                                                          0.381830050505118944950369775488975L, 0.417959183673469387755102040816327L};
    const long double middle = (low + high) / 2, half = (high - low) / 2;
    Entries kronrod{}, gauss{};
    for (std::size_t i = 0; i < kNodes.size(); ++i)
        for (const long double side : {-1.0L, 1.0L}) {
            if (i == 7 && side > 0) continue;
            const Entries value = function(middle + side * half * kNodes[i]);
            for (std::size_t k = 0; k < value.size(); ++k) {
                kronrod[k] += half * kKronrod[i] * value[k];
                if (i % 2 == 1) gauss[k] += half * kGauss[i / 2] * value[k];
            }
        }
    long double error = 0;
    for (std::size_t k = 0; k < kronrod.size(); ++k) error = std::max(error, std::abs(kronrod[k] - gauss[k]));
    if (error <= tolerance || depth == 0) return kronrod;
    const Entries left = adaptive(function, low, middle, tolerance / 2, depth - 1);
    Entries both = adaptive(function, middle, high, tolerance / 2, depth - 1);
    for (std::size_t k = 0; k < both.size(); ++k) both[k] += left[k];
    return both;
}

/// Eq. 6 with the corrections, as printed: D, G and Fresnel at a half vector, dw_l = 4 VoH dw_h.
Entries integrand(long double NoV, long double m, bool isGgx, long double theta, long double phi) {
    Entries value{};
    const long double viewX = std::sqrt(1 - NoV * NoV), NoH = std::cos(theta), sinH = std::sin(theta);
    const long double hx = sinH * std::cos(phi), hy = sinH * std::sin(phi), VoH = hx * viewX + NoH * NoV;
    const long double lx = 2 * VoH * hx - viewX, ly = 2 * VoH * hy, lz = 2 * VoH * NoH - NoV;
    if (VoH <= 0 || lz <= 0 || NoH <= 0) return value;
    const long double tan2 = sinH * sinH / (NoH * NoH), term = NoH * NoH * (m * m - 1) + 1;
    const long double D = isGgx ? m * m / (kLongPi * term * term) : std::exp(-tan2 / (m * m)) / (kLongPi * m * m * NoH * NoH * NoH * NoH);
    const long double G = std::min({1.0L, 2 * NoH * NoV / VoH, 2 * NoH * lz / VoH});
    const long double weight = 2 * D * G * VoH / NoV * sinH;
    const std::array<long double, 6> basis = {0.5L * std::sqrt(1 / kLongPi),
                                              std::sqrt(3 / (4 * kLongPi)) * lz,
                                              std::sqrt(3 / (4 * kLongPi)) * lx,
                                              0.25L * std::sqrt(5 / kLongPi) * (3 * lz * lz - 1),
                                              0.5L * std::sqrt(15 / kLongPi) * lx * lz,
                                              0.25L * std::sqrt(15 / kLongPi) * (lx * lx - ly * ly)};
    const long double rest = 1 - VoH, fresnel = rest * rest * rest * rest * rest;
    for (std::size_t k = 0; k < basis.size(); ++k) {
        value[k] = weight * basis[k];
        value[6 + k] = value[k] * fresnel;
    }
    return value;
}

Entries reference(long double NoV, long double m, bool isGgx, long double tolerance) {
    // The polar angle is atan(m y), so that the lobe fills the range. Intervals shrink towards the lobe's centre and towards the azimuth
    // across the view, which dominates at grazing views: a symmetric rule over the whole interval could accept equal values on both sides
    // of it.
    const auto overPolar = [&](long double t) {
        const long double y = t / (1 - t), theta = std::atan(m * y), slope = m / (1 + m * m * y * y) / ((1 - t) * (1 - t));
        Entries sum{};
        for (int side = -1; side <= 1; side += 2)
            for (int part = 0; part < 9; ++part) {
                const long double far = std::pow(0.3L, part) * kLongPi / 2, near = part == 8 ? 0 : 0.3L * far;
                const Entries value = adaptive([&](long double phi) { return integrand(NoV, m, isGgx, theta, phi); },
                                               kLongPi / 2 + side * near, kLongPi / 2 + side * far, tolerance / slope / 20, 30);
                for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += side * slope * value[k];
            }
        return sum;
    };
    const long double end = isGgx ? 1 - 1e-12L : 7.0L / 8;
    Entries sum{};
    for (int part = 0; part < 8; ++part) {
        const long double far = std::pow(0.25L, part) * end, near = part == 7 ? 0 : 0.25L * far;
        const Entries value = adaptive(overPolar, near, far, tolerance, 14);
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += value[k];
    }
    return sum;
}

double errorAt(double NoV, double m, bool isGgx) {
    const Entries expected = reference(NoV, m, isGgx, 5e-9L);
    const Entries found = entriesOf(areaSpecular(NoV, m, isGgx ? SpecularLobe::Ggx : SpecularLobe::Beckmann, kEnergyForm));
    long double norm = 0, worst = 0;
    for (std::size_t k = 0; k < 12; ++k) {
        norm = std::max(norm, std::abs(expected[k]));
        worst = std::max(worst, std::abs(found[k] - expected[k]));
    }
    return static_cast<double>(worst / norm);
}

TEST(AreaSpecular, MatchesAdaptiveLongDouble) {
    for (const bool isGgx : {false, true})
        for (const double m : {1e-4, 0.3, 1.0})
            for (const double NoV : {1e-3, 0.6}) EXPECT_LT(errorAt(NoV, m, isGgx), 1e-7) << NoV << " " << m << " ggx " << isGgx;
}

TEST(AreaSpecularSoak, MatchesAdaptiveLongDoubleAnywhere) {
    test::repeatInSoak("random cases", 1, [](std::uint64_t seed) {
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> uniform(0, 1);
        const double NoV = seed % 3 == 0 ? std::pow(10, -3 * uniform(random)) : uniform(random), m = std::pow(10, -4 * uniform(random));
        EXPECT_LT(errorAt(NoV, m, seed % 2 == 0), 1e-7) << NoV << " " << m;
    });
}

TEST(AreaSpecular, AgreesWithTheSumOverHalfVectors) {
    for (const NormalDistribution distribution : {NormalDistribution::Beckmann, NormalDistribution::Ggx})
        for (const double m : {0.01, 0.1, 0.45, 0.9})
            for (const double NoV : {0.05, 0.3, 0.7, 0.98}) {
                const auto lobe = distribution == NormalDistribution::Beckmann ? SpecularLobe::Beckmann : SpecularLobe::Ggx;
                const AreaSpecularKernel sum = integrateAreaSpecular(NoV, m, distribution, kHalo3Form, 600);
                const AreaSpecularKernel kernel = areaSpecular(NoV, m, lobe, kHalo3Form);
                for (std::size_t i = 0; i < 9; ++i) {
                    EXPECT_NEAR(kernel.c[i], sum.c[i], 2e-5) << m << " " << NoV;
                    EXPECT_NEAR(kernel.d[i], sum.d[i], 2e-5) << m << " " << NoV;
                }
            }
}

TEST(AreaSpecular, ColumnsServeEveryRoughnessInTheirRange) {
    for (const SpecularLobe lobe : kLobes)
        for (const double NoV : {0.0, 1e-3, 0.2, 0.8, 1.0}) {
            const AreaSpecularColumn column(NoV, 0.01, 1, lobe);
            for (const double m : {0.01, 0.03, 0.2, 0.7, 1.0}) {
                const Entries shared = entriesOf(column.kernel(m, kEnergyForm)), own = entriesOf(areaSpecular(NoV, m, lobe, kEnergyForm));
                for (std::size_t k = 0; k < 12; ++k)
                    EXPECT_NEAR(static_cast<double>(shared[k]), static_cast<double>(own[k]), 2e-8) << NoV << " " << m << " " << k;
            }
        }
}

TEST(AreaSpecular, PhongBandsAreThoseOfItsLobe) {
    for (const double m : {1e-4, 0.05, 0.4, 1.0})
        for (const SpecularLobe lobe : {SpecularLobe::Phong, SpecularLobe::PhongPower}) {
            // Over cos a, dense at the lobe, by one substitution for the lobe (a = atan(m y)) and the whole hemisphere.
            std::array<double, 3> bands{};
            constexpr int kCount = 200000;
            for (int i = 0; i < kCount; ++i) {
                const double t = (i + 0.5) / kCount, y = t / (1 - t), tangent = m * y, cosine = 1 / std::sqrt(1 + tangent * tangent);
                const double dAngle = m / (1 + tangent * tangent) / ((1 - t) * (1 - t)) / kCount;
                const double value = lobe == SpecularLobe::Phong ? phongBeckmannLobe(cosine, m) : phongLobe(cosine, 2 / (m * m) - 2);
                const double weight = 2 * static_cast<double>(kLongPi) * value * tangent * cosine * dAngle;
                bands[0] += weight;
                bands[1] += weight * cosine;
                bands[2] += weight * (1.5 * cosine * cosine - 0.5);
            }
            const ShBands found = phongBands(lobe, m);
            for (std::size_t l = 0; l < 3; ++l) EXPECT_NEAR(found[l], bands[l], 2e-7) << "m " << m << " band " << l;
        }
}

TEST(AreaSpecular, PhongIsItsLobeAroundTheReflection) {
    const AreaSpecularKernel kernel = areaSpecular(0.6, 0.3, SpecularLobe::Phong, kEnergyForm);
    const ShDouble basis = evaluateBasis(glm::dvec3(-0.8, 0, 0.6));
    const ShBands bands = phongBands(SpecularLobe::Phong, 0.3);
    for (std::size_t i = 0; i < 9; ++i) {
        EXPECT_NEAR(kernel.c[i], bands[static_cast<std::size_t>(kShBand[i])] * basis[i], 1e-15);
        EXPECT_NEAR(kernel.d[i], std::pow(0.4, 5) * kernel.c[i], 1e-15);
    }
}

/// For any view and roughness: finite, no energy gain, D within C, band norms within the Cauchy-Schwarz bound, and a mirror at small m.
void expectSound(const AreaSpecularKernel& kernel, double NoV, double m) {
    const double albedo = kernel.c[0] / kShConstant, schlick = kernel.d[0] / kShConstant;
    ASSERT_GE(albedo, 0) << NoV << " " << m;
    ASSERT_LE(albedo, 1 + 2e-3) << NoV << " " << m;
    ASSERT_GE(schlick, -1e-3) << NoV << " " << m;
    ASSERT_LE(schlick, albedo + 2e-3) << NoV << " " << m;
    for (const ShDouble* part : {&kernel.c, &kernel.d}) {
        const ShDouble& k = *part;
        const double whole = k[0] / kShConstant;
        ASSERT_LE(std::hypot(k[2], k[3]), kShLinear * whole + 2e-3) << NoV << " " << m;
        ASSERT_LE(std::sqrt(k[6] * k[6] + k[7] * k[7] + k[8] * k[8]), std::sqrt(5.0) * kShConstant * whole + 2e-3) << NoV << " " << m;
        ASSERT_EQ(k[1], 0);
        ASSERT_EQ(k[4], 0);
        ASSERT_EQ(k[5], 0);
    }
}

/// A case is one view and one roughness. A hundred roughnesses share the column of a view, with a narrow or wide range; every thousandth
/// case has a column of its own.
void expectSoundAnywhere(long long count, unsigned seed) {
    constexpr int kRoughnesses = 100;
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (long long i = 0; i < count / kRoughnesses; ++i) {
        const double NoV = i % 4 == 0   ? std::pow(10, -12 * uniform(random))
                           : i % 4 == 1 ? 1 - std::pow(10, -12 * uniform(random))
                                        : uniform(random);
        const SpecularLobe lobe = kLobes[static_cast<std::size_t>(i % 5) % 4];
        const double low = i % 3 == 0 ? uniform(random) : std::pow(10, -4 * uniform(random));
        const double high = i % 2 == 0 ? low + (1 - low) * uniform(random) : std::min(1.0, low * (1 + uniform(random)));
        const AreaSpecularColumn column(NoV, std::max(low, 1e-4), std::max(high, 1e-4), lobe, 10);
        for (int k = 0; k < kRoughnesses; ++k) {
            const double m = std::max(low + (high - low) * uniform(random), 1e-4);
            expectSound(column.kernel(m, kEnergyForm), NoV, m);
            if (k == 0 && i % 10 == 0) expectSound(areaSpecular(NoV, m, lobe, kEnergyForm, 6), NoV, m);
            if (testing::Test::HasFatalFailure()) return;
        }
    }
}

TEST(AreaSpecular, HasItsPropertiesInManyRandomCases) {
    for (const SpecularLobe lobe : kLobes)
        for (const double m : {1e-4, 0.5, 1.0})
            for (const double NoV : {0.0, 1e-300, 1e-9, 1e-3, 0.5, 1.0}) expectSound(areaSpecular(NoV, m, lobe, kEnergyForm, 6), NoV, m);
    expectSoundAnywhere(100'000, 3);
}

TEST(AreaSpecularSoak, HasItsPropertiesInAnyRandomCase) {
    test::repeatInSoak("random cases", 100'000, [](std::uint64_t seed) { expectSoundAnywhere(100'000, static_cast<unsigned>(seed)); });
}

}  // namespace
}  // namespace lightcook::lighting
