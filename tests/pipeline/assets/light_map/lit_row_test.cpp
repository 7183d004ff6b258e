#include "pipeline/assets/light_map/lit_row.h"

#include <gtest/gtest.h>

#include <random>

#include "lighting/display.h"

namespace lightcook::pipeline {
namespace {

/// The cap's worst normal is no better than the texel's own and no worse than the worst of many normals of the same cap.
TEST(NormalCap, FindsNearlyTheWorstNormal) {
    constexpr double kTilt = 60;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(-1, 1);
    const verify::Viewing viewing;
    NormalCap cap(kTilt, viewing);
    LitRow own(1, viewing);
    for (int round = 0; round < 50; ++round) {
        lighting::ShRgb reference{}, found{};
        reference[0] = glm::vec3(1);
        for (std::size_t i = 1; i < reference.size(); ++i) reference[i] = 0.2f * glm::vec3(unit(random), unit(random), unit(random));
        for (std::size_t i = 0; i < found.size(); ++i)
            found[i] = reference[i] + 0.03f * glm::vec3(unit(random), unit(random), unit(random));
        const glm::vec3 normal = glm::normalize(glm::vec3(unit(random), unit(random), unit(random) + 1.5f));
        own.set(0, reference, found, normal);
        own.compare();
        double most = 0;
        for (int i = 0; i < 20000; ++i) {
            const glm::vec3 other = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)));
            if (static_cast<double>(glm::dot(other, normal)) < std::cos(kTilt * std::numbers::pi / 180)) continue;
            const auto lightOf = [&](const lighting::ShRgb& sh) {
                return glm::dvec3(lighting::lambertExitRadiance(sh, other, glm::vec3(1)).value);
            };
            most =
                std::max(most, lighting::visibleDifference(lightOf(reference), lightOf(found), viewing.display, viewing.bt2020FromWorking));
        }
        const auto worst = static_cast<double>(cap.worst(reference, found, normal));
        EXPECT_GE(worst, static_cast<double>(own.visible(0)) * (1 - 1e-4));
        EXPECT_LE(worst, 1.02 * most + 0.01);
        EXPECT_GE(worst, 0.8 * most);
    }
}

}  // namespace
}  // namespace lightcook::pipeline
