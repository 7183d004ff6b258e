// Random tables, codes and normals for tests of the learned layouts.
#pragma once

#include <gtest/gtest.h>

#include <array>
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
    glm::vec3 randomNormal() { return glm::vec3(lighting::fibonacciSphere(static_cast<int>(random_() % 1000), 1000)); }

    std::mt19937 random_{11};
};

/// Returns e' M e.
inline double cost(const compress::Metric& metric, const std::array<double, 9>& error) {
    double sum = 0;
    for (std::size_t i = 0; i < 9; ++i)
        for (std::size_t j = 0; j < 9; ++j) sum += static_cast<double>(metric[i][j]) * error[i] * error[j];
    return sum;
}

}  // namespace lightcook::synthetic
