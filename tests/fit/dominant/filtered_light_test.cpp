// Lights fitted for the filter: maps with known answers, and properties for any input.
#include "fit/filtered_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/fit/brute_force.h"
#include "tests/fit/dominant/lit_map.h"

namespace lightcook {
namespace {

using formats::Image;
using test::explained;
using test::Map;

/// Two charts that touch: each has a light of its own, and no surface lies between them.
Map touchingCharts() {
    Map map(8, 6);
    map.chart = Image<std::uint32_t>(8, 6, 1);
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 8; ++x) {
            const bool isRight = x >= 4;
            map.sh.at(x, y) = lighting::projectDirectional(glm::vec3(isRight ? -0.8f : 0.8f, 0, 0.6f), glm::vec3(isRight ? 0.02f : 5.0f));
            if (isRight) map.chart.at(x, y) = 2;
        }
    return map;
}

double degreesBetween(const glm::dvec3& a, const glm::dvec3& b) {
    return std::acos(std::clamp(glm::dot(glm::normalize(a), glm::normalize(b)), -1.0, 1.0)) * 180 / std::numbers::pi;
}

/// The edge of a shadow: a strong light on the left, a hundredth of it from another side on the right.
const glm::vec3 kSun = glm::normalize(glm::vec3(1, 0.2f, 0.5f)), kSky = glm::normalize(glm::vec3(-1, 0.3f, 0.4f));
Map shadowEdge() {
    Map map(8, 6);
    for (int y = 0; y < map.height(); ++y)
        for (int x = 0; x < map.width(); ++x)
            map.sh.at(x, y) = lighting::projectDirectional(x < 4 ? kSun : kSky, glm::vec3(x < 4 ? 1.0f : 0.01f));
    return map;
}

TEST(FilteredLight, ChartsThatTouchKeepTheirOwnLights) {
    Map map = touchingCharts(), mixed = touchingCharts();
    mixed.chart = {};
    for (Map* each : {&map, &mixed}) each->fitTexels(explained().light);
    const Map before = map.copy();
    for (Map* each : {&map, &mixed}) each->fitForFilter(explained());
    int solved = 0;
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 8; ++x) {
            EXPECT_EQ(map.solved.at(x, y), 0);
            EXPECT_EQ(map.intensity.at(x, y), before.intensity.at(x, y));
            EXPECT_LT(glm::distance(map.direction.at(x, y), glm::normalize(before.direction.at(x, y))), 1e-6f) << "of full length";
            solved += mixed.solved.at(x, y);
        }
    EXPECT_GT(solved, 0) << "one chart with an edge of light";
}

/// In the middle of the edge the bake holds half the strong light and half the weak one: nearly the strong one's direction.
TEST(FilteredLight, PointsAtTheStrongLightInTheMiddleOfAShadowsEdge) {
    Map map = shadowEdge();
    fit::FilteredLightOptions options = explained();
    options.shortest = 0.02;
    map.fitTexels(options.light);
    const auto middle = [&] { return glm::dvec3(map.direction.at(3, 2)) + glm::dvec3(map.direction.at(4, 2)); };
    EXPECT_GT(degreesBetween(middle(), glm::dvec3(kSun)), 30) << "each texel alone";
    map.fitForFilter(options);
    EXPECT_LT(degreesBetween(middle(), glm::dvec3(kSun)), 4);
    EXPECT_NEAR(0.5f * (map.intensity.at(3, 2).x + map.intensity.at(4, 2).x), 0.5, 0.02);
    EXPECT_LT(degreesBetween(glm::dvec3(map.direction.at(3, 2)), glm::dvec3(kSun)), 2) << "the strong light's own texel";
    EXPECT_NEAR(map.intensity.at(3, 2).x, 1, 0.02);
    EXPECT_EQ(map.solved.at(0, 0), 0) << "far from the edge nothing is unknown";
    EXPECT_EQ(map.direction.at(0, 0), map.direction.at(1, 3));
    EXPECT_LT(glm::distance(map.direction.at(0, 0), kSun), 1e-6f);
}

/// Four lights of equal strength from four sides: their mean is no light, and `explained` dims it. Texels alone would show a bright light
/// from a direction that none of them has.
TEST(FilteredLight, DimsALightThatIsNoneBetweenTexels) {
    Map map(12, 12);
    truth::Random random(3);
    for (lighting::ShRgb& sh : map.sh.texels()) sh = lighting::projectDirectional(glm::vec3(random.direction()), glm::vec3(1));
    fit::FilteredLightOptions options = explained();
    map.fitTexels(options.light);
    const auto meanAt = [&](int x, int y) {
        float sum = 0;
        for (int i = 0; i < 4; ++i) sum += 0.25f * map.intensity.at(x + i % 2, y + i / 2).x;
        return sum;
    };
    EXPECT_NEAR(meanAt(5, 5), 1, 1e-5);
    options.mostAtCentre = 10, options.centreWeight = 0.1;
    map.fitForFilter(options);
    double mean = 0;
    for (int i = 0; i < 121; ++i) mean += meanAt(i % 11, i / 11) / 121;
    EXPECT_LT(mean, 0.7) << "nothing but the places between texels counts";
}

TEST(FilteredLight, TexelsKeepCloseToTheirOwnLight) {
    Map map(24, 24);
    truth::Random random(4);
    for (lighting::ShRgb& sh : map.sh.texels())
        sh = lighting::projectDirectional(glm::vec3(random.direction()), glm::vec3(static_cast<float>(std::pow(100, random.uniform()))));
    const fit::FilteredLightOptions options = explained();
    map.fitTexels(options.light);
    const Map alone = map.copy();
    map.fitForFilter(options);
    for (int y = 0; y < map.height(); ++y)
        for (int x = 0; x < map.width(); ++x) {
            const double own = glm::length(glm::dvec3(alone.intensity.at(x, y)));
            EXPECT_LE(glm::length(glm::dvec3(map.intensity.at(x, y)) - glm::dvec3(alone.intensity.at(x, y))),
                      options.mostAtCentre * (own + options.floor) * (1 + 1e-5));
            EXPECT_EQ(map.solved.at(x, y), 1);
            EXPECT_LE(glm::length(map.direction.at(x, y)), 1 + 1e-6f);
            EXPECT_GE(glm::length(map.direction.at(x, y)), options.shortest - 1e-6);
        }
}

/// Random lights with holes and differing normals.
Map roughMap(std::uint64_t seed, int width, int height) {
    Map map(width, height);
    truth::Random random(seed);
    for (std::size_t i = 0; i < map.sh.texels().size(); ++i) {
        const glm::dvec3 towards = glm::dvec3(0, 0.5, 1) + 0.6 * random.direction();
        map.sh.texels()[i] =
            lighting::projectDirectional(glm::vec3(glm::normalize(towards)), glm::vec3(static_cast<float>(random.uniform() + 0.1)));
        map.sh.texels()[i][0] += glm::vec3(0.05f);
        map.covered.texels()[i] = random.below(10) != 0;
        map.normal.texels()[i] = glm::vec3(glm::normalize(glm::dvec3(0, 0, 1) + 0.3 * random.direction()));
    }
    return map;
}

/// Strips that are solved with four rows around them give what the whole map gives, but for the rows that they share.
TEST(FilteredLight, StripsThatOverlapAgreeWithTheWholeMap) {
    constexpr int kHeight = 48, kStrip = 16, kShared = 4, kMargin = kShared + fit::kFilteredLightMargin;
    const fit::FilteredLightOptions options = explained();
    Map whole = roughMap(6, 20, kHeight);
    whole.fitTexels(options.light);
    const Map texels = whole.copy();
    whole.fitForFilter(options);
    double apart = 0, moved = 0;
    for (int first = 0; first < kHeight; first += kStrip) {
        const int begin = std::max(0, first - kMargin), end = std::min(kHeight, first + kStrip + kMargin);
        Map strip(20, end - begin);
        const auto copyRows = [&](auto& to, const auto& from) {
            for (int y = begin; y < end; ++y)
                for (int x = 0; x < 20; ++x) to.at(x, y - begin) = from.at(x, y);
        };
        copyRows(strip.sh, texels.sh), copyRows(strip.covered, texels.covered), copyRows(strip.normal, texels.normal);
        copyRows(strip.direction, texels.direction), copyRows(strip.intensity, texels.intensity);
        const int solvedFrom = std::max(0, first - kShared) - begin, solvedTo = std::min(kHeight, first + kStrip + kShared) - begin;
        Map again = strip.copy();
        strip.fitForFilter(options, solvedFrom, solvedTo - solvedFrom);
        again.fitForFilter(options, solvedFrom, solvedTo - solvedFrom);
        EXPECT_EQ(strip.direction.texels(), again.direction.texels());
        EXPECT_EQ(strip.intensity.texels(), again.intensity.texels());
        for (int y = first; y < first + kStrip; ++y)
            for (int x = 0; x < 20; ++x) {
                EXPECT_EQ(strip.solved.at(x, y - begin), whole.solved.at(x, y)) << x << ", " << y;
                apart += glm::distance(strip.intensity.at(x, y - begin), whole.intensity.at(x, y));
                moved += glm::distance(texels.intensity.at(x, y), whole.intensity.at(x, y));
            }
    }
    EXPECT_GT(moved, 0);
    EXPECT_LT(apart, 0.02 * moved);
}

/// Rows that are not to be solved keep their intensity and the direction but for its length; texels outside charts keep everything.
TEST(FilteredLight, RowsOutsideTheSolvedOnesOnlyChangeLengths) {
    const fit::FilteredLightOptions options = explained();
    Map map = roughMap(7, 16, 16);
    map.fitTexels(options.light);
    const Map before = map.copy();
    map.fitForFilter(options, 6, 4);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            if (map.covered.at(x, y) == 0) {
                EXPECT_EQ(map.direction.at(x, y), before.direction.at(x, y));
                EXPECT_EQ(map.intensity.at(x, y), before.intensity.at(x, y));
                EXPECT_EQ(map.solved.at(x, y), 0);
            } else if (y < 6 || y >= 10) {
                EXPECT_EQ(map.intensity.at(x, y), before.intensity.at(x, y));
                EXPECT_LT(degreesBetween(glm::dvec3(map.direction.at(x, y)), glm::dvec3(before.direction.at(x, y))), 0.01);
                EXPECT_EQ(map.solved.at(x, y), 0);
            }
        }
}

TEST(FilteredLight, ConstantLightIsNotSolved) {
    Map map(9, 9);
    for (lighting::ShRgb& sh : map.sh.texels()) sh = lighting::projectDirectional(kSun, glm::vec3(2, 1, 0));
    const fit::FilteredLightOptions options = explained();
    map.fitTexels(options.light);
    const Map before = map.copy();
    map.fitForFilter(options);
    EXPECT_EQ(map.solved.texels(), std::vector<std::uint8_t>(81, 0));
    EXPECT_EQ(map.intensity.texels(), before.intensity.texels());
    for (const glm::vec3& direction : map.direction.texels()) EXPECT_LT(glm::distance(direction, kSun), 1e-6f);
}

TEST(FilteredLight, IsFiniteForAnyFiniteInput) {
    truth::Random random(8);
    for (int trial = 0; trial < 200; ++trial) {
        Map map(6, 5);
        const int kind = trial % 4;
        for (std::size_t i = 0; i < map.sh.texels().size(); ++i) {
            const double exponent = kind == 0 ? 38 : kind == 1 ? -44 : 76 * random.uniform() - 38;
            for (glm::vec3& c : map.sh.texels()[i])
                for (int k = 0; k < 3; ++k) c[k] = static_cast<float>((2 * random.uniform() - 1) * std::pow(10, exponent));
            if (kind == 3 && random.below(2) == 0) map.sh.texels()[i] = {};
            map.covered.texels()[i] = random.below(6) != 0;
            map.normal.texels()[i] = glm::vec3(random.direction());
        }
        fit::FilteredLightOptions options = explained();
        options.floor = trial % 3 == 0 ? 0 : 1e-3;
        map.fitTexels(options.light);
        map.fitForFilter(options);
        for (std::size_t i = 0; i < map.sh.texels().size(); ++i)
            for (int k = 0; k < 3; ++k) {
                ASSERT_TRUE(std::isfinite(map.direction.texels()[i][k])) << trial;
                ASSERT_TRUE(std::isfinite(map.intensity.texels()[i][k])) << trial;
                ASSERT_GE(map.intensity.texels()[i][k], 0) << trial;
            }
    }
}

}  // namespace
}  // namespace lightcook
