#include "fit/specular_tables.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <stdexcept>

#include "tests/fit/brute_force.h"

namespace lightcook {
namespace {

using fit::SpecularTableOptions;
using truth::kLongPi;

/// C and D for i = 0, 2, 3, 6, 7, 8, directly from eq. 6 with the corrections, over half vectors: dw_l = 4 VoH dw_h.
struct Kernel {
    std::array<long double, 6> c{}, d{};
};
Kernel reference(long double NoV, long double m, bool ggx, int count) {
    Kernel sum;
    const long double viewX = std::sqrt(1 - NoV * NoV);
    const long double reach = ggx ? kLongPi / 2 : std::min(kLongPi / 2, std::atan(7 * m));
    for (int i = 0; i < count; ++i) {
        // Points are dense at the lobe's centre, and the map is flat at both ends, so that midpoints converge with the fourth power of
        // their count.
        const long double t = (i + 0.5L) / count, u = 1 - t;
        const long double theta = reach * t * t * t * t * (35 - 84 * t + 70 * t * t - 20 * t * t * t);
        const long double dTheta = reach * 140 * t * t * t * u * u * u / count;
        const long double NoH = std::cos(theta), sinH = std::sin(theta), tan2 = sinH * sinH / (NoH * NoH);
        const long double ggxTerm = NoH * NoH * (m * m - 1) + 1;
        const long double D =
            ggx ? m * m / (kLongPi * ggxTerm * ggxTerm) : std::exp(-tan2 / (m * m)) / (kLongPi * m * m * NoH * NoH * NoH * NoH);
        for (int j = 0; j < count; ++j) {
            const long double phi = kLongPi * (j + 0.5L) / count;
            const long double hx = sinH * std::cos(phi), hy = sinH * std::sin(phi);
            const long double VoH = hx * viewX + NoH * NoV;
            const long double lx = 2 * VoH * hx - viewX, ly = 2 * VoH * hy, lz = 2 * VoH * NoH - NoV;
            if (VoH <= 0 || lz <= 0) continue;
            const long double G = std::min({1.0L, 2 * NoH * NoV / VoH, 2 * NoH * lz / VoH});
            // R_m NoL dw_l = D G / (4 NoL NoV) NoL 4 VoH dw_h; both halves of phi.
            const long double weight = D * G * VoH / NoV * sinH * dTheta * 2 * kLongPi / count;
            const long double fresnel = std::pow(1 - VoH, 5);
            const long double y[6] = {0.5L * std::sqrt(1 / kLongPi),
                                      std::sqrt(3 / (4 * kLongPi)) * lz,
                                      std::sqrt(3 / (4 * kLongPi)) * lx,
                                      0.25L * std::sqrt(5 / kLongPi) * (3 * lz * lz - 1),
                                      0.5L * std::sqrt(15 / kLongPi) * lx * lz,
                                      0.25L * std::sqrt(15 / kLongPi) * (lx * lx - ly * ly)};
            for (std::size_t k = 0; k < 6; ++k) {
                sum.c[k] += weight * y[k];
                sum.d[k] += weight * fresnel * y[k];
            }
        }
    }
    return sum;
}

void expectRowsNearReference(bool ggx, double minimumM, double maximumM, int count) {
    SpecularTableOptions options;
    options.lobe = ggx ? lighting::SpecularLobe::Ggx : lighting::SpecularLobe::Beckmann;
    options.view = fit::viewMapping("sin(theta_v)");
    options.roughnessCount = 2;
    options.minimumM = minimumM;
    options.maximumM = maximumM;
    const fit::SpecularTables tables = fit::makeSpecularTables(options);
    for (int y = 0; y < 2; ++y) {
        for (const int x : {0, 3, 6}) {
            const double sine = tables.view.value(x);
            const Kernel expected =
                reference(std::sqrt(1 - static_cast<long double>(sine) * sine), y == 0 ? minimumM : maximumM, ggx, count);
            const glm::vec4 c = tables.c0236.values.at(x, y), d = tables.d0236.values.at(x, y), cd = tables.cd78.values.at(x, y);
            const double values[12] = {c.x, c.y, c.z, c.w, cd.x, cd.y, d.x, d.y, d.z, d.w, cd.z, cd.w};
            for (std::size_t k = 0; k < 12; ++k) {
                const double truth = static_cast<double>(k < 6 ? expected.c[k] : expected.d[k - 6]);
                // Half a step of 16 bits, and the error of this reference; lighting/brdf/area_specular_test.cpp has a better one.
                EXPECT_NEAR(values[k], truth, k < 6 ? 4e-6 : 4e-7)
                    << "m " << (y == 0 ? minimumM : maximumM) << " view " << x << " entry " << k;
            }
        }
    }
}

TEST(SpecularTables, BeckmannMatchesLongDouble) {
    expectRowsNearReference(false, 1.0 / 16, 1, 700);
}
TEST(SpecularTables, GgxMatchesLongDouble) {
    expectRowsNearReference(true, 0.1, 0.6, 700);
}

TEST(SpecularTables, StoredCodesDecodeWithinHalfAStep) {
    SpecularTableOptions options;
    const fit::SpecularTables tables = fit::makeSpecularTables(options);
    for (const fit::SpecularTexture* texture : {&tables.c0236, &tables.d0236, &tables.cd78}) {
        for (std::size_t texel = 0; texel < texture->stored.texels().size(); ++texel) {
            for (int channel = 0; channel < 4; ++channel) {
                const double stored = texture->stored.texels()[texel][channel] / 65535.0;
                const double decoded = stored * texture->scale[channel] + texture->bias[channel];
                EXPECT_NEAR(decoded, texture->values.texels()[texel][channel], 0.5001 / 65535 * texture->scale[channel]);
            }
        }
        EXPECT_EQ(texture->stored.width(), 8);
        EXPECT_EQ(texture->stored.height(), 16);
    }
}

TEST(SpecularTables, SmoothMirrorHasTheDeltasHarmonics) {
    SpecularTableOptions options;
    options.view = fit::viewMapping("sin(theta_v)");
    options.roughnessCount = 1;
    options.minimumM = options.maximumM = 0.005;
    const fit::SpecularTables tables = fit::makeSpecularTables(options);
    // At normal incidence the lobe is a delta towards z: C_i = Y_i(z), and Schlick's term is 0.
    const lighting::ShDouble basis = lighting::evaluateBasis(glm::dvec3(0, 0, 1));
    const glm::vec4 c = tables.c0236.values.at(0, 0), d = tables.d0236.values.at(0, 0);
    EXPECT_NEAR(c.x, basis[0], 1e-3);
    EXPECT_NEAR(c.y, basis[2], 1e-3);
    EXPECT_NEAR(c.z, 0, 1e-3);
    EXPECT_NEAR(c.w, basis[6], 1e-3);
    EXPECT_NEAR(d.x, 0, 1e-9);
}

TEST(SpecularTables, Halo3IsFourTimesEnergyAndPassesTwo) {
    SpecularTableOptions options;
    options.view = fit::viewMapping("sin(theta_v)");
    const fit::SpecularTables energy = fit::makeSpecularTables(options);
    options.normalization = lighting::CookTorranceNormalization::Halo3;
    const fit::SpecularTables halo3 = fit::makeSpecularTables(options);
    for (std::size_t texel = 0; texel < energy.c0236.values.texels().size(); ++texel) {
        for (int channel = 0; channel < 4; ++channel) {
            EXPECT_NEAR(halo3.c0236.values.texels()[texel][channel], 4 * energy.c0236.values.texels()[texel][channel], 1e-5);
            EXPECT_NEAR(halo3.cd78.values.texels()[texel][channel], 4 * energy.cd78.values.texels()[texel][channel], 1e-5);
        }
    }
    // Correction of the paper (docs/theory/lighting.md, "Specular tables"): 2.46 at m = 1/16 and normal incidence, outside the paper's (-2,
    // 2).
    EXPECT_NEAR(halo3.c0236.values.at(0, 0).w, 2.46, 0.01);
    for (const glm::vec4& value : energy.c0236.values.texels()) EXPECT_LT(std::max({value.x, value.y, value.z, value.w}), 0.63);
}

TEST(SpecularTables, WhiteSurfaceReflectsNoMoreThanItReceives) {
    for (const bool ggx : {false, true}) {
        SpecularTableOptions options;
        options.lobe = ggx ? lighting::SpecularLobe::Ggx : lighting::SpecularLobe::Beckmann;
        const fit::SpecularTables tables = fit::makeSpecularTables(options);
        for (const glm::vec4& value : tables.c0236.values.texels()) {
            const double albedo = value.x * std::sqrt(4 * static_cast<double>(kLongPi));  // f0 = 1 under constant light
            EXPECT_GT(albedo, 0);
            EXPECT_LT(albedo, 1 + 1e-4);
        }
    }
}

TEST(SpecularTables, AxesGiveTheValuesAtTexelCentres) {
    SpecularTableOptions options;
    options.roughness = fit::roughnessMapping("sqrt(m)");
    options.minimumM = 0.09;
    options.maximumM = 0.49;
    const fit::SpecularTables tables = fit::makeSpecularTables(options);
    EXPECT_NEAR(tables.roughness.value(0), 0.3, 1e-12);
    EXPECT_NEAR(tables.roughness.value(15), 0.7, 1e-12);
    for (int x = 0; x < 8; ++x) {
        for (int y = 0; y < 16; ++y) {
            const double u = tables.view.value(x) * tables.view.coordinateScale + tables.view.coordinateOffset;
            const double v = tables.roughness.value(y) * tables.roughness.coordinateScale + tables.roughness.coordinateOffset;
            EXPECT_NEAR(u, (x + 0.5) / 8, 1e-12);
            EXPECT_NEAR(v, (y + 0.5) / 16, 1e-12);
            const glm::vec4 sampled = fit::sampleSpecularTexture(tables.c0236, u, v), value = tables.c0236.values.at(x, y);
            for (int channel = 0; channel < 4; ++channel) EXPECT_NEAR(sampled[channel], value[channel], 1e-5);
        }
    }
    // The last column of the cosine mapping is the view along the normal.
    EXPECT_NEAR(tables.c0236.values.at(7, 3).z, 0, 1e-6);
}

TEST(SpecularTables, MappingsAreMonotoneAndTheirOwnInverse) {
    for (const auto* mappings : {&fit::viewMappings(), &fit::roughnessMappings()})
        for (const fit::AxisMapping& mapping : *mappings) {
            const double rising = mapping.of(1) > mapping.of(0) ? 1 : -1;
            double last = mapping.of(0) - rising;
            for (int i = 0; i <= 1000; ++i) {
                const double t = i / 1000.0, value = mapping.of(t);
                EXPECT_GT(rising * value, rising * last) << mapping.name << " " << t;
                EXPECT_NEAR(mapping.inverse(value), t, 1e-7) << mapping.name;
                last = value;
            }
            EXPECT_EQ(mapping.inverse(-1e9), mapping.inverse(1e9)) << "clamped, not NaN: " << mapping.name;
        }
    EXPECT_NEAR(fit::viewMapping("sin(theta_v)").of(0.6), 0.8, 1e-15);
    EXPECT_NEAR(fit::viewMapping("sqrt((1 - NoV) (1 - 0.8 NoV))").of(0.5), std::sqrt(0.5 * 0.6), 1e-15);
    EXPECT_THROW(fit::viewMapping("m"), std::out_of_range);
}

TEST(SpecularTables, TheChosenAxesHaveTheLeastErrorAndLessThanHalfOfThePapers) {
    for (const auto lobe : {lighting::SpecularLobe::Beckmann, lighting::SpecularLobe::Ggx, lighting::SpecularLobe::Phong}) {
        SpecularTableOptions options;
        options.lobe = lobe;
        fit::SpecularTableOptions chosen = options;
        fit::chooseMappings(chosen, 0.04, 0.6);
        double least = 1, ours = 1, papers = 0, plain = 0;
        for (const fit::MappingFigure& figure : fit::mappingFigures(options, 0.04, 0.6)) {
            least = std::min(least, figure.reflected);
            if (figure.view == chosen.view.name && figure.roughness == chosen.roughness.name) ours = figure.reflected;
            if (figure.view == "sin(theta_v)" && figure.roughness == "m") papers = figure.reflected;
            if (figure.view == "NoV" && figure.roughness == "m") plain = figure.reflected;
        }
        EXPECT_LE(ours, 1.04 * least) << "a plain axis may stay for 3 %";
        EXPECT_LT(ours, papers / 8);
        EXPECT_LT(ours, 0.75 * plain);
    }
}

TEST(SpecularTables, PhongTablesHoldTheReflectedHarmonics) {
    SpecularTableOptions options;
    options.lobe = lighting::SpecularLobe::PhongPower;
    const fit::SpecularTables tables = fit::makeSpecularTables(options);
    for (int y = 0; y < 16; ++y) {
        const double m = (y + 1) / 16.0, exponent = 2 / (m * m) - 2, NoV = 3 / 7.0;
        const lighting::ShDouble basis = lighting::evaluateBasis(glm::dvec3(-std::sqrt(1 - NoV * NoV), 0, NoV));
        EXPECT_NEAR(tables.c0236.values.at(3, y).x, basis[0], 1e-6);
        EXPECT_NEAR(tables.c0236.values.at(3, y).z, basis[3] * (exponent + 1) / (exponent + 2), 1e-6);
        EXPECT_NEAR(tables.cd78.values.at(3, y).x, basis[7] * exponent / (exponent + 3), 1e-6);
        EXPECT_NEAR(tables.d0236.values.at(3, y).x, basis[0] * std::pow(1 - NoV, 5), 1e-6);
    }
}

TEST(SpecularTables, OneRoughnessIsOneRow) {
    SpecularTableOptions options;
    options.roughnessCount = 1;
    options.minimumM = options.maximumM = 0.25;
    const fit::SpecularTables tables = fit::makeSpecularTables(options);
    EXPECT_EQ(tables.c0236.stored.height(), 1);
    EXPECT_EQ(tables.roughness.value(0), 0.25);
    for (const double v : {0.0, 0.5, 1.0}) {
        EXPECT_NEAR(fit::sampleSpecularTexture(tables.c0236, 0.5 / 8, v).x, tables.c0236.values.at(0, 0).x, 1e-5);
    }
}

TEST(SpecularTables, GrazingAndRoughEndsAreFinite) {
    for (const bool ggx : {false, true}) {
        SpecularTableOptions options;
        options.lobe = ggx ? lighting::SpecularLobe::Ggx : lighting::SpecularLobe::Beckmann;
        options.minimumM = 0.005;
        const fit::SpecularTables tables = fit::makeSpecularTables(options);
        for (const fit::SpecularTexture* texture : {&tables.c0236, &tables.d0236, &tables.cd78}) {
            for (const glm::vec4& value : texture->values.texels()) {
                for (int channel = 0; channel < 4; ++channel) ASSERT_LT(std::abs(value[channel]), 0.7f);
            }
        }
    }
}

TEST(SpecularTables, BadOptionsAreRefused) {
    const auto refused = [](auto&& change) {
        SpecularTableOptions options;
        change(options);
        return !fit::checkSpecularTableOptions(options).has_value();
    };
    EXPECT_FALSE(refused([](SpecularTableOptions&) {}));
    EXPECT_TRUE(refused([](SpecularTableOptions& o) { o.viewCount = 1; }));
    EXPECT_TRUE(refused([](SpecularTableOptions& o) { o.minimumM = 0; }));
    EXPECT_TRUE(refused([](SpecularTableOptions& o) { o.minimumM = std::numeric_limits<double>::quiet_NaN(); }));
    EXPECT_TRUE(refused([](SpecularTableOptions& o) { o.maximumM = 1.5; }));
    EXPECT_TRUE(refused([](SpecularTableOptions& o) { o.minimumM = 0.5, o.maximumM = 0.4; }));
    EXPECT_TRUE(refused([](SpecularTableOptions& o) { o.roughnessCount = 1; }));
    EXPECT_TRUE(refused([](SpecularTableOptions& o) { o.pointCount = 0; }));
}

TEST(SpecularTables, RowsOnTheirOwnGiveTheSameTables) {
    SpecularTableOptions options;
    const fit::SpecularTables whole = fit::makeSpecularTables(options);
    std::vector<std::vector<lighting::AreaSpecularKernel>> rows(16);
    for (int y = 15; y >= 0; --y) rows[static_cast<std::size_t>(y)] = fit::integrateSpecularTableRow(options, y);
    const fit::SpecularTables pieces = fit::assembleSpecularTables(options, rows);
    EXPECT_EQ(whole.cd78.stored.texels(), pieces.cd78.stored.texels());
    EXPECT_EQ(whole.c0236.bias, pieces.c0236.bias);
}

TEST(SpecularTables, TheDefaultSetTakesLessThanASecond) {
    const std::clock_t begin = std::clock();
    const fit::SpecularTables tables = fit::makeSpecularTables({});
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    std::printf("[ figures  ] twelve tables 16 x 8: %.3f CPU s\n", seconds);
    EXPECT_GT(tables.c0236.scale.x, 0);
    EXPECT_LT(seconds, 1) << "three milliseconds on the machine of docs/lab/fit.md";
}

}  // namespace
}  // namespace lightcook
