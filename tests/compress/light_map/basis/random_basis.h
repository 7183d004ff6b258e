// Random tables, codes and normals for tests of the learned layouts.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <random>

#include "compress/light_map/basis/model.h"
#include "lighting/sphere.h"

namespace lightcook::synthetic {

class BasisTest : public testing::Test {
protected:
    float uniform(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
    glm::vec4 randomCode() { return {uniform(0, 1), uniform(0, 1), uniform(0, 1), uniform(0, 1)}; }
    compress::CodeTable randomTable(float bend) {
        compress::CodeTable table;
        for (std::size_t m = 0; m < table.size(); ++m)
            for (auto& channel : table[m])
                for (float& value : channel) value = uniform(-1, 1) * (m >= 4 && m != 10 ? bend : 1.0f);
        return table;
    }
    compress::ResidualTable randomResidual() {
        compress::ResidualTable table;
        for (compress::ByChannel& k : table)
            for (auto& channel : k)
                for (float& value : channel) value = uniform(-1, 1);
        return table;
    }
    /// Returns the cost of a texel around a random normal under random light.
    compress::RatioCost randomCost(bool isVisible) {
        std::array<glm::vec3, 9> light;
        for (glm::vec3& value : light) value = 0.2f * glm::vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
        light[0] = glm::vec3(1, 0.7f, 1.4f);
        compress::LightMapObjective objective;
        objective.display.nitsPerUnit = 1;
        compress::ShadingForm shading(isVisible ? std::optional(objective) : std::nullopt, 1);
        return {shading.at(light, randomNormal()).unpacked(), light[0]};
    }
    glm::vec3 randomNormal() { return glm::vec3(lighting::fibonacciSphere(static_cast<int>(random_() % 1000), 1000)); }

    std::mt19937 random_{11};
};

/// Returns e' Q e of an error of ratios.
inline double cost(const compress::RatioCost& form, const compress::ByChannel& error) {
    const compress::WeightedRatios weighted = compress::times(form, error);
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        sum += static_cast<double>(weighted.zero[c]) * static_cast<double>(error[c][0]);
        for (std::size_t i = 0; i < 8; ++i) sum += static_cast<double>(weighted.higher[c][i]) * static_cast<double>(error[c][i + 1]);
    }
    return sum;
}

}  // namespace lightcook::synthetic
