#include "verify/rsrm.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "fit/azimuthal_average.h"

namespace lightcook::verify {
namespace {

using formats::Environment;

Environment emptyEnvironment(bool isPanorama, int size) {
    return {isPanorama ? Environment::Projection::Equirectangular : Environment::Projection::CubeStrip,
            formats::Image<glm::vec3>(isPanorama ? 2 * size : size, isPanorama ? size : 6 * size)};
}

Environment noise(bool isPanorama, int size) {
    Environment environment = emptyEnvironment(isPanorama, size);
    std::uint32_t state = 12345;
    for (glm::vec3& texel : environment.texels.texels()) {
        state = state * 1664525u + 1013904223u;
        texel = glm::vec3(static_cast<float>(state >> 8) / 16777216.0f, state % 7 == 0 ? 50.0f : 0.1f, 1);
    }
    return environment;
}

/// Compares two independent methods: closed forms of whole texels, and lines cut at the zones' edges.
TEST(AxialGradient, AgreesWithTheClosedForm) {
    for (const bool isPanorama : {true, false})
        for (const int size : {1, 24})
            for (const glm::dvec3& axis : {glm::dvec3(0, 1, 0), glm::dvec3(0, -1, 0), glm::dvec3(1, 0, 0), glm::dvec3(0.2, 0.9, -0.4),
                                           glm::dvec3(-1, -1, 1), glm::dvec3(0, 1, 0.02)})
                for (const int zoneCount : {64, 300}) {
                    const Environment environment = noise(isPanorama, size);
                    const AxialGradient found = axialGradient(environment, axis, zoneCount);
                    const fit::AzimuthalAverage expected = fit::averageAroundAxis(environment, axis, zoneCount);
                    EXPECT_NEAR(found.asymmetricEnergy, expected.asymmetricEnergy, 2e-3);
                    for (std::size_t zone = 0; zone < expected.gradient.size(); ++zone)
                        for (int channel = 0; channel < 3; ++channel)
                            ASSERT_NEAR(found.gradient[zone][channel], expected.gradient[zone][channel],
                                        found.uncertainty[channel] + 50 * (1e-8 * zoneCount + 1e-7))
                                << "size " << size << " zones " << zoneCount << " zone " << zone << " panorama " << isPanorama << " axis "
                                << axis.x << " " << axis.y << " " << axis.z;
                    // For zones much narrower than texels, one line makes a large difference.
                    EXPECT_LT(found.uncertainty.y, zoneCount <= 64 ? 0.2 : 2) << size << " " << zoneCount << " " << isPanorama;
                }
}

TEST(AxialGradient, AConstantStaysConstantAndIsSymmetric) {
    for (const bool isPanorama : {true, false}) {
        Environment environment = emptyEnvironment(isPanorama, 16);
        for (glm::vec3& texel : environment.texels.texels()) texel = glm::vec3(0.5f, 2, 0);
        const AxialGradient found = axialGradient(environment, {1, 2, 3}, 256);
        for (const glm::vec3& zone : found.gradient) {
            ASSERT_NEAR(zone.x, 0.5, 1e-6);
            ASSERT_NEAR(zone.y, 2, 1e-6);
        }
        EXPECT_LT(found.asymmetricEnergy, 1e-12);
        EXPECT_LT(found.uncertainty.y, 1e-10);
    }
}

}  // namespace
}  // namespace lightcook::verify
