// Lights fitted for the filter: maps with known answers, the sum of squares against Ceres, and properties for any input.
#include "fit/filtered_light.h"

#include <ceres/ceres.h>
#include <ceres/sphere_manifold.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/fit/brute_force.h"

namespace lightcook {
namespace {

using formats::Image;

/// A map, and the lights of its texels.
struct Map {
    Image<lighting::ShRgb> sh;
    Image<std::uint8_t> covered;
    Image<glm::vec3> normal, direction, intensity;
    Image<std::uint8_t> solved;

    Map(int width, int height)
        : sh(width, height),
          covered(width, height, 1),
          normal(width, height, glm::vec3(0, 0, 1)),
          direction(width, height),
          intensity(width, height),
          solved(width, height, 7) {}
    int width() const { return sh.width(); }
    int height() const { return sh.height(); }
    fit::DominantLightRows rows() { return {sh.view(), covered.view(), normal.view(), direction.view(), intensity.view()}; }

    void fitTexels(const fit::DominantLightOptions& options) { fit::fitDominantLights(rows(), options); }
    void fitForFilter(const fit::FilteredLightOptions& options, int firstRow, int rowCount) {
        fit::fitForFilter(rows(), solved.view(), firstRow, rowCount, options);
    }
    void fitForFilter(const fit::FilteredLightOptions& options) { fitForFilter(options, 0, height()); }
    Map copy() const {
        Map other(width(), height());
        other.sh = sh.copy(), other.covered = covered.copy(), other.normal = normal.copy();
        other.direction = direction.copy(), other.intensity = intensity.copy(), other.solved = solved.copy();
        return other;
    }
};

fit::FilteredLightOptions explained() {
    fit::FilteredLightOptions options;
    options.light.fit = fit::DominantFit::Explained;
    options.floor = 0.01;
    return options;
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

/// The sum that the fit minimises, written a second time: residuals whose squares are E.
struct PlaceResidual {
    int count;
    glm::dvec3 direction, intensity;
    double weight;

    template <class T>
    bool operator()(const T* const* lights, T* residuals) const {
        using std::sqrt;
        T towards[3] = {T(0), T(0), T(0)}, light[3] = {T(0), T(0), T(0)}, squared(1e-18), apart(0);
        for (int i = 0; i < count; ++i)
            for (int k = 0; k < 3; ++k) towards[k] += lights[2 * i][k] / T(count), light[k] += lights[2 * i + 1][k] / T(count);
        for (const T& each : towards) squared += each * each;
        for (int k = 0; k < 3; ++k) towards[k] = towards[k] / sqrt(squared) - T(direction[k]), apart += towards[k] * towards[k];
        const T spread = T(1) + T(5.35) * apart, overlap = T(1) / (spread * spread);
        // (1 - g^2) / |d - d*|^2 without a division by zero.
        const T turned = T(5.35) * (spread + T(1)) * (spread * spread + T(1)) * overlap * overlap;
        const double scale = std::sqrt(weight);
        for (int k = 0; k < 3; ++k) {
            residuals[k] = T(scale) * (light[k] - overlap * T(intensity[k]));
            residuals[3 + k] = T(scale * glm::length(intensity)) * sqrt(turned) * towards[k];
        }
        return true;
    }
};

/// All places of a fully covered map with their light.
class CeresFit {
public:
    CeresFit(const Map& map, const fit::FilteredLightOptions& options) : map_(map) {
        for (int y = 0; y < map.height(); ++y)
            for (int x = 0; x < map.width(); ++x)
                for (int kind = 0; kind < 4; ++kind) {
                    const int right = kind % 2, below = kind / 2;
                    if (x + right < map.width() && y + below < map.height()) add(x, y, right, below, options);
                }
    }

    /// Returns the sum for some lights, before or after a minimisation.
    double sumOf(const Map& lights, bool isMinimised) const {
        std::vector<double> values;
        for (std::size_t i = 0; i < lights.direction.texels().size(); ++i) {
            for (int k = 0; k < 3; ++k) values.push_back(static_cast<double>(lights.direction.texels()[i][k]));
            for (int k = 0; k < 3; ++k) values.push_back(static_cast<double>(lights.intensity.texels()[i][k]));
        }
        ceres::Problem problem;
        for (const auto& [residual, texels] : places_) {
            auto* cost = new ceres::DynamicAutoDiffCostFunction<PlaceResidual, 6>(new PlaceResidual(residual));
            std::vector<double*> blocks;
            for (const int texel : texels)
                for (const int at : {6 * texel, 6 * texel + 3}) {
                    cost->AddParameterBlock(3);
                    blocks.push_back(&values[static_cast<std::size_t>(at)]);
                }
            cost->SetNumResiduals(6);
            problem.AddResidualBlock(cost, nullptr, blocks);
        }
        for (std::size_t i = 0; i < values.size(); i += 6) {
            problem.SetManifold(&values[i], new ceres::SphereManifold<3>);  // keeps the length
            for (int k = 0; k < 3; ++k) problem.SetParameterLowerBound(&values[i + 3], k, 0);
        }
        ceres::Solver::Options options;
        options.logging_type = ceres::SILENT;
        options.max_num_iterations = isMinimised ? 200 : 0;
        ceres::Solver::Summary summary;
        ceres::Solve(options, &problem, &summary);
        return 2 * summary.final_cost;
    }

private:
    void add(int x, int y, int right, int below, const fit::FilteredLightOptions& options) {
        const int count = (1 + right) * (1 + below);
        lighting::ShRgb sh{};
        std::vector<int> texels;
        for (int i = 0; i <= below; ++i)
            for (int j = 0; j <= right; ++j) {
                texels.push_back((y + i) * map_.width() + x + j);
                for (std::size_t k = 0; k < sh.size(); ++k) sh[k] += map_.sh.at(x + j, y + i)[k] / static_cast<float>(count);
            }
        const fit::DominantLight light = fit::dominantLight(sh, glm::vec3(0, 0, 1), options.light);
        const double scale = glm::length(glm::dvec3(light.intensity)) + options.floor;
        places_.push_back({{count, glm::normalize(glm::dvec3(light.direction)), glm::dvec3(light.intensity),
                            (count == 1 ? options.centreWeight : 1) / (scale * scale)},
                           texels});
    }

    struct PlaceOfTexels {
        PlaceResidual residual;
        std::vector<int> texels;
    };
    const Map& map_;
    std::vector<PlaceOfTexels> places_;
};

/// Ceres moves all lights together until nothing changes, and knows no limits of lengths. A few sweeps, texel by texel, gain most of what
/// it gains.
TEST(FilteredLight, CeresGainsHardlyMoreFromTheSameStart) {
    truth::Random random(5);
    for (int trial = 0; trial < 12; ++trial) {
        Map map(7, 6);
        const double jitter = trial < 6 ? 0.02 : 0.2;
        const glm::dvec3 first = random.direction(), second = random.direction();
        for (int y = 0; y < map.height(); ++y)
            for (int x = 0; x < map.width(); ++x) {
                const bool isLit = x + 0.4 * y < 4.5;
                const glm::dvec3 towards = (isLit ? first : second) + jitter * random.direction();
                const double brightness = (isLit ? 2 : 0.2) * (1 + 5 * jitter * (random.uniform() - 0.5));
                map.sh.at(x, y) =
                    lighting::projectDirectional(glm::vec3(glm::normalize(towards)), glm::vec3(static_cast<float>(brightness)));
                map.sh.at(x, y)[0] += glm::vec3(0.02f);
            }
        fit::FilteredLightOptions options = explained();
        options.light.fit = fit::DominantFit::Refined;
        options.tolerance = 0, options.mostAtCentre = 1e3;
        map.fitTexels(options.light);
        fit::FilteredLightOptions lengthsAlone = options;
        lengthsAlone.tolerance = 1e9;
        map.fitForFilter(lengthsAlone);
        const CeresFit truth(map, options);
        const double before = truth.sumOf(map, false), byCeres = truth.sumOf(map, true);
        map.fitTexels(options.light);
        map.fitForFilter(options);
        const double found = truth.sumOf(map, false);
        EXPECT_GT(before - found, 0.85 * (before - byCeres)) << trial << ": " << before << ", " << found;
        EXPECT_GT(found, 0.99 * std::min(byCeres, truth.sumOf(map, true))) << trial;
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
