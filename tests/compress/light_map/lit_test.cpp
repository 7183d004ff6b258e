// Family lit: one light and the ratios of the rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "compress/light_map/lit_fit.h"
#include "shaders/lightcook_cpp.h"
#include "tests/compress/light_map/synthetic_plan.h"

namespace lightcook {
namespace {

using compress::rows::LitFit;
using synthetic::Kind;

constexpr std::array<float, LitFit::kHigher> kAnyRatio = {9, 9, 9, 9, 9, 9, 9, 9};

/// Light that the layout holds exactly: one light of its own for each texel, and a rest whose ratios squares of `side` texels share.
formats::LightMapStrip separableLight(int size, int side) {
    formats::LightMapStrip strip = synthetic::makeBand(Kind::Grey, size, 0, size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const auto a = 0.3f * static_cast<float>(x), b = 0.2f * static_cast<float>(y);
            const int square = x / side + 2 * (y / side);
            const float slope = 0.4f * std::sin(static_cast<float>(square));
            const glm::vec3 ambient(1 + 0.3f * std::cos(a), 0.5f, 0.8f);
            lighting::ShRgb sh = synthetic::constantLight(ambient);
            for (std::size_t i = 1; i < sh.size(); ++i) sh[i] = slope / static_cast<float>(i) * sh[0];
            const glm::vec3 towards = glm::normalize(glm::vec3(std::cos(a), std::sin(b), 1));
            strip.sh.at(x, y) = synthetic::add(sh, lighting::projectDirectional(towards, glm::vec3(3, 2 + std::sin(b), 1)));
        }
    return strip;
}

/// Returns the largest error of a coefficient of the fit over the largest coefficient 0.
float errorOf(LitFit& fit, const formats::LightMapStrip& strip, int side) {
    float largest = 0, light = 0;
    fit.forEachCovered([&](int x, int y) {
        const lighting::Sh basis = lighting::evaluateBasis(fit.directionAt(x, y));
        const lighting::ShRgb& sh = strip.sh.at(x, y);
        light = std::max({light, sh[0].x, sh[0].y, sh[0].z});
        for (std::size_t i = 0; i < LitFit::kHigher; ++i) {
            const glm::vec3 found = fit.restAt(x, y) * fit.ratio(i, x / side, y / side) + fit.intensity().at(x, y) * basis[i + 1];
            const glm::vec3 off = glm::abs(found - sh[i + 1]);
            largest = std::max({largest, off.x, off.y, off.z});
        }
    });
    return largest / light;
}

TEST(LitFit, FindsALightAndARestThatItCanHold) {
    for (const int side : {1, 2, 4}) {
        const formats::LightMapStrip strip = separableLight(16, side);
        const auto plan = synthetic::planOf(formats::LightMapLayout::Lit, formats::Target::Float, strip, synthetic::fast());
        const compress::rows::Source source = compress::rows::makeSource(plan, strip, 0, 16);
        LitFit fit(source, 1, side, kAnyRatio);
        const float start = errorOf(fit, strip, side);
        for (int turn = 0; turn < 20; ++turn) fit.solve(false);
        EXPECT_LT(errorOf(fit, strip, side), 0.02f) << side;
        EXPECT_LT(errorOf(fit, strip, side), 0.3f * start) << side;
    }
}

TEST(LitFit, KeepsTheRestAndTheRatiosInBounds) {
    for (const Kind kind : {Kind::Gradient, Kind::NegativeBands, Kind::Spikes, Kind::Black, Kind::Night}) {
        const formats::LightMapStrip strip = synthetic::makeBand(kind, synthetic::kWidth, 0, synthetic::kHeight);
        const auto plan = synthetic::planOf(formats::LightMapLayout::LitHalf, formats::Target::Float, strip, synthetic::fast());
        const compress::rows::Source source = compress::rows::makeSource(plan, strip, 0, synthetic::kHeight);
        LitFit fit(source, 1, 2, kAnyRatio);
        fit.solve(false);
        fit.forEachCovered([&](int x, int y) {
            const glm::vec3 &intensity = fit.intensity().at(x, y), rest = fit.restAt(x, y);
            EXPECT_NEAR(glm::length(fit.directionAt(x, y)), 1, 1e-5f);
            for (int c = 0; c < 3; ++c) {
                EXPECT_GE(intensity[c], 0);
                EXPECT_GE(rest[c], 0.0199f * fit.dc().at(x, y)[c]);
            }
        });
        for (int v = 0; v < fit.down(); ++v)
            for (int u = 0; u < fit.across(); ++u)
                for (std::size_t i = 0; i < LitFit::kHigher; ++i)
                    for (int c = 0; c < 3; ++c) EXPECT_LE(std::abs(fit.ratio(i, u, v)[c]), kAnyRatio[i]);
    }
}

TEST(Lit, LightOutsideChartsDoesNotChangeTheBytes) {
    for (const auto layout : {formats::LightMapLayout::Lit, formats::LightMapLayout::LitHalf, formats::LightMapLayout::LitQuarter}) {
        const auto plan = synthetic::planOf(Kind::Gradient, layout, formats::Target::Bc);
        const auto encoded = [&](float outside) {
            const auto strip = synthetic::makeBand(Kind::Gradient, synthetic::kWidth, 0, synthetic::kHeight, outside);
            return compress::encodeLightMapRows(plan, strip, 0, synthetic::kHeight, synthetic::fast());
        };
        const auto a = encoded(0), b = encoded(1000);
        for (std::size_t t = 0; t < a.textures.size(); ++t) EXPECT_EQ(a.textures[t].layers, b.textures[t].layers);
    }
}

TEST(Coverage, TheShaderReadsTheBitOfEachTexel) {
    std::mt19937 random(1);
    for (const glm::ivec2 size : {glm::ivec2(1, 1), {8, 4}, {37, 23}, {64, 12}}) {
        formats::LightMapStrip strip;
        strip.firstRow = 4;
        strip.covered = formats::Image<std::uint8_t>(size.x, size.y);
        for (std::uint8_t& texel : strip.covered.texels()) texel = static_cast<std::uint8_t>(random() % 2);
        const std::vector<std::byte> bytes = compress::coverageTexels(strip, 4, size.y);
        const int across = (size.x + formats::kCoverageColumns - 1) / formats::kCoverageColumns;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const glm::vec2 texel(x, y);
                const glm::ivec2 at(shaders::lcCoverageTexel(texel));
                glm::vec4 stored;
                for (int c = 0; c < 4; ++c)
                    stored[c] =
                        static_cast<float>(std::to_integer<int>(bytes.at(static_cast<std::size_t>(4 * (at.y * across + at.x) + c)))) / 255;
                EXPECT_EQ(shaders::lcCovered(stored, texel), strip.covered.at(x, y)) << x << ", " << y;
            }
    }
}

}  // namespace
}  // namespace lightcook
