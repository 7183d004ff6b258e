// Extreme light in maps of awkward sizes, through every layout: results are finite, and within the verifier's bounds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "lighting/sphere.h"
#include "tests/compress/synthetic_light_map.h"
#include "tests/verify/cooked_light_map.h"

namespace lightcook {
namespace {

using formats::LightMapLayout;
using formats::Target;
using synthetic::constantLight;

using Light = std::function<lighting::ShRgb(int x, int y)>;

lighting::ShRgb scaled(lighting::ShRgb sh, float factor) {
    for (glm::vec3& c : sh) c *= factor;
    return sh;
}

lighting::ShRgb lamp(const glm::vec3& color) {
    return lighting::projectDirectional(glm::normalize(glm::vec3(0.3f, 0.8f, -0.5f)), color);
}

struct Case {
    const char* name;
    Light light;
};
const std::vector<Case>& cases() {
    static const std::vector<Case> all = {
        {"Black", [](int, int) { return lighting::ShRgb{}; }},
        {"Constant", [](int, int) { return scaled(synthetic::gradientLight(3, 1), 1); }},
        {"OneBrightTexel", [](int x, int y) { return x == 2 && y == 1 ? lamp(glm::vec3(65504)) : lighting::ShRgb{}; }},
        {"OneBrightTexelInLight", [](int x, int y) { return x == 2 && y == 1 ? lamp(glm::vec3(65504)) : synthetic::gradientLight(x, y); }},
        {"NegativeBands", [](int x, int y) { return synthetic::lightAt(synthetic::Kind::NegativeBands, x, y); }},
        {"OnlyBand2",
         [](int x, int y) {
             lighting::ShRgb sh = constantLight(glm::vec3(1));
             sh[4 + static_cast<std::size_t>(x + y) % 5] = glm::vec3(2, -2, 1);
             return sh;
         }},
        {"Saturated",
         [](int x, int y) {
             glm::vec3 color(0);
             color[(x / 3 + y / 2) % 3] = 2;
             return lamp(color);
         }},
        {"SunEdge",
         [](int x, int y) {
             return synthetic::add(constantLight(glm::vec3(1e-3f, 2e-3f, 4e-3f)), x + y > 9 ? lamp(glm::vec3(300, 280, 200)) : lamp({}));
         }},
        {"OpposingAxes",
         [](int x, int y) {
             const glm::vec3 towards = (x + y) % 2 == 0 ? glm::vec3(0, 1, 0) : glm::vec3(0, -1, 0);
             return synthetic::add(constantLight(glm::vec3(0.2f)), lighting::projectDirectional(towards, glm::vec3(1, 0.9f, 0.8f)));
         }},
        {"Vast", [](int x, int y) { return scaled(synthetic::gradientLight(x, y), 1e30f); }},
        {"Tiny", [](int x, int y) { return scaled(synthetic::gradientLight(x, y), 1e-30f); }},
        {"FromTinyToVast",
         [](int x, int y) {
             return scaled(synthetic::gradientLight(x, y), std::pow(10.0f, static_cast<float>((x * 7 + y * 3) % 13) - 6));
         }},
    };
    return all;
}

/// Coverage patterns of a width x height map.
struct Shape {
    const char* name;
    int width, height;
    bool (*isCovered)(int x, int y);
};
constexpr std::array kShapes = {Shape{"blocks", 16, 12, [](int, int) { return true; }},
                                Shape{"one texel", 1, 1, [](int, int) { return true; }},
                                Shape{"5 x 3", 5, 3, [](int, int) { return true; }},
                                Shape{"one covered", 9, 6, [](int x, int y) { return x == 2 && y == 1; }},
                                Shape{"uncovered", 9, 6, [](int, int) { return false; }},
                                Shape{"strewn", 13, 11, [](int x, int y) { return (x * 5 + y * 3) % 7 < 4; }}};

formats::LightMapStrip makeBand(const Light& light, const Shape& shape) {
    formats::LightMapStrip band;
    band.sh = formats::Image<lighting::ShRgb>(shape.width, shape.height);
    band.covered = formats::Image<std::uint8_t>(shape.width, shape.height, 0);
    band.normal = formats::Image<glm::vec3>(shape.width, shape.height, glm::vec3(0, 0, 1));
    band.tangent = formats::Image<glm::vec4>(shape.width, shape.height, glm::vec4(1, 0, 0, 1));
    for (int y = 0; y < shape.height; ++y)
        for (int x = 0; x < shape.width; ++x) {
            band.covered.at(x, y) = shape.isCovered(x, y) ? 1 : 0;
            // Uncovered texels may have any value.
            band.sh.at(x, y) = shape.isCovered(x, y) ? light(x, y) : constantLight(glm::vec3(std::numeric_limits<float>::quiet_NaN()));
        }
    return band;
}

void expectSound(const verify::ErrorFigures& figures) {
    for (const double figure : {figures.relRms, figures.p99, figures.maxSampled, *figures.maxBound}) EXPECT_TRUE(std::isfinite(figure));
    EXPECT_LE(figures.maxSampled, figures.maxBound);
}

/// every  of the shapes for each light, or whole blocks and another shape in turn
void expectSoundResults(LightMapLayout layout, bool every) {
    verify::LightMapShading shading;
    shading.m = {0.25};
    shading.viewCount = 4;
    verify::LightMapSampling sampling;
    sampling.placesPerTexel = 8;
    std::size_t turn = 0;
    for (const Case& each : cases()) {
        const Shape& inTurn = kShapes[1 + turn++ % (kShapes.size() - 1)];
        for (const Shape& shape : kShapes) {
            if (!every && &shape != &kShapes.front() && &shape != &inTurn) continue;
            for (const Target target : {Target::Bc, Target::Astc, Target::Float}) {
                // The library of ASTC takes whole blocks of any shape alike.
                if (target == Target::Astc && &shape != &kShapes.front()) continue;
                SCOPED_TRACE(std::string(each.name) + ", " + shape.name + ", target " + std::to_string(static_cast<int>(target)));
                const test::Cooked cooked = test::cook(makeBand(each.light, shape), layout, target, 1);
                for (const auto& [name, values] : cooked.map.constants)
                    EXPECT_TRUE(std::ranges::all_of(values, [](float v) { return std::isfinite(v); })) << name;
                const verify::LightMapVerifier verifier = cooked.verifier(shading, sampling);
                const auto seen = verifier.reconstruct(cooked.texels, 0, shape.height, 1, &cooked.reference);
                for (const lighting::ShRgb& sh : seen.texels())
                    for (const glm::vec3& c : sh) ASSERT_TRUE(std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z));
                for (const verify::StageError& stage : verifier.verifyRows(cooked.texels, cooked.reference, 0, shape.height).figures()) {
                    SCOPED_TRACE(stage.name);
                    expectSound(stage.diffuse);
                    expectSound(stage.specular);
                }
                if (testing::Test::HasFailure()) return;
            }
        }
    }
}

class Stress : public testing::TestWithParam<LightMapLayout> {};
class StressSoak : public testing::TestWithParam<LightMapLayout> {};

TEST_P(Stress, ResultsAreFiniteAndWithinTheBound) {
    expectSoundResults(GetParam(), false);
}
TEST_P(StressSoak, ResultsAreFiniteAndWithinTheBound) {
    expectSoundResults(GetParam(), true);
}

INSTANTIATE_TEST_SUITE_P(Layouts, Stress, testing::ValuesIn(test::layoutsOfEveryFamily()), test::nameOfLayout);
INSTANTIATE_TEST_SUITE_P(Layouts, StressSoak, testing::ValuesIn(test::kEveryLayout), test::nameOfLayout);

}  // namespace
}  // namespace lightcook
