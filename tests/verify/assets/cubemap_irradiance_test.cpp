// The verifier's reference of an irradiance cubemap against the plain sum over every texel.
#include "verify/cubemap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <vector>

#include "lighting/cube.h"
#include "lighting/sphere.h"

namespace lightcook::verify {
namespace {

using formats::Environment;
using formats::Image;

/// Returns the plain sum over every texel's centre, weighted by solid angle, over the sum of the weights.
glm::dvec3 plainSum(const Environment& environment, const glm::dvec3& normal, double wrap) {
    const int width = environment.texels.width(), height = environment.texels.height();
    const bool isPanorama = environment.projection == Environment::Projection::Equirectangular;
    glm::dvec3 sum(0);
    double weights = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 direction = isPanorama ? lighting::directionFromEquirectangular({(x + 0.5) / width, (y + 0.5) / height})
                                                    : lighting::cubeTexelDirection(y / width, x, y % width, width);
            const double solidAngle = isPanorama ? lighting::equirectangularTexelSolidAngle(y, width, height)
                                                 : lighting::cubeTexelSolidAngle(x, y % width, width);
            const double weight = std::max(0.0, glm::dot(normal, direction) + wrap) * solidAngle;
            sum += weight * glm::dvec3(environment.texels.at(x, y));
            weights += weight;
        }
    return sum / weights;
}

/// Returns the figures of the verifier for a float cubemap of the plain sums.
IrradianceFigures comparePlainSums(const Environment& environment, double wrap) {
    constexpr int kSize = 3;
    std::vector<Image<glm::vec4>> faces;
    for (int face = 0; face < 6; ++face) {
        faces.emplace_back(kSize, kSize);
        for (int i = 0; i < kSize * kSize; ++i)
            faces.back().at(i % kSize, i / kSize) =
                glm::vec4(plainSum(environment, lighting::cubeTexelDirection(face, i % kSize, i / kSize, kSize), wrap), 1);
    }
    return compareIrradiance(faces, 1, wrap, environment);
}

TEST(CompareIrradiance, ItsReferenceIsTheSumOverEveryTexel) {
    std::mt19937 random(1);
    for (const auto& [width, height, isPanorama] :
         {std::tuple{64, 32, true}, {33, 7, true}, {2, 1, true}, {1, 1, true}, {5, 40, true}, {8, 48, false}, {1, 6, false}})
        for (const double wrap : {0.0, 0.3, 1.0}) {
            Environment environment{isPanorama ? Environment::Projection::Equirectangular : Environment::Projection::CubeStrip,
                                    Image<glm::vec3>(width, height)};
            for (glm::vec3& texel : environment.texels.texels())
                texel = glm::vec3(std::pow(static_cast<float>(random() % 1000) / 1000, 4.0f), random() % 2 == 0 ? 0 : 1, 0.3f);
            environment.texels.at(width / 2, height / 3) = glm::vec3(60000, 1, 0);
            EXPECT_LT(comparePlainSums(environment, wrap).worst, 2e-7) << width << " x " << height << " wrap " << wrap;
        }
}

TEST(CompareIrradiance, ATexelThatIsNotFinitePassesNoLimit) {
    const Environment environment{Environment::Projection::Equirectangular, Image<glm::vec3>(16, 8, glm::vec3(1))};
    for (const float value : {NAN, HUGE_VALF}) {
        std::vector<Image<glm::vec4>> faces;
        for (int face = 0; face < 6; ++face) faces.emplace_back(3, 3, glm::vec4(1));
        EXPECT_LT(compareIrradiance(faces, 1, 0, environment).relRms, 1e-6);
        faces[4].at(1, 2).x = value;
        const IrradianceFigures figures = compareIrradiance(faces, 1, 0, environment);
        EXPECT_GT(figures.relRms, 1e100);
        EXPECT_GT(figures.worst, 1e100);
    }
}

TEST(CompareIrradiance, EveryTexelCounts) {
    constexpr int kSize = 16;
    const Environment environment{Environment::Projection::Equirectangular, Image<glm::vec3>(64, 32, glm::vec3(1))};
    std::vector<Image<glm::vec4>> faces;
    for (int face = 0; face < 6; ++face) faces.emplace_back(kSize, kSize, glm::vec4(1));
    const IrradianceFigures right = compareIrradiance(faces, 1, 0, environment);
    EXPECT_EQ(right.texelCount, 6 * kSize * kSize);
    EXPECT_LT(right.worst, 1e-6);
    for (int texel = 0; texel < 6 * kSize * kSize; texel += 37) {
        glm::vec4& stored = faces[static_cast<std::size_t>(texel / (kSize * kSize))].at(texel % kSize, texel / kSize % kSize);
        stored = glm::vec4(0.5f);
        const IrradianceFigures wrong = compareIrradiance(faces, 1, 0, environment);
        EXPECT_NEAR(wrong.worst, 0.5 / 1.02, 1e-5) << texel;
        EXPECT_NEAR(wrong.relRms, 0.5 / std::sqrt(6 * kSize * kSize), 1e-6) << texel;
        stored = glm::vec4(1);
    }
}

TEST(CompareIrradiance, ASingleBrightTexelIsCountedInEveryReference) {
    std::mt19937 random(2);
    for (int trial = 0; trial < 300; ++trial) {
        Environment environment{Environment::Projection::Equirectangular, Image<glm::vec3>(16, 8, glm::vec3(0.01f))};
        environment.texels.at(static_cast<int>(random() % 16), static_cast<int>(random() % 8)) = glm::vec3(1e6f);
        EXPECT_LT(comparePlainSums(environment, trial % 3 == 0 ? 0.5 : 0).worst, 1e-6) << trial;
    }
}

}  // namespace
}  // namespace lightcook::verify
