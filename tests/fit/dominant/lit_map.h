// A map of light with the dominant lights of its texels.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "fit/filtered_light.h"

namespace lightcook::test {

/// A map, and the lights of its texels.
struct Map {
    formats::Image<lighting::ShRgb> sh;
    formats::Image<std::uint8_t> covered;
    formats::Image<glm::vec3> normal, direction, intensity;
    formats::Image<std::uint8_t> solved;
    formats::Image<std::uint32_t> chart = {};  ///< empty: none

    Map(int width, int height)
        : sh(width, height),
          covered(width, height, 1),
          normal(width, height, glm::vec3(0, 0, 1)),
          direction(width, height),
          intensity(width, height),
          solved(width, height, 7) {}
    int width() const { return sh.width(); }
    int height() const { return sh.height(); }
    fit::DominantLightRows rows() { return {sh.view(), covered.view(), normal.view(), direction.view(), intensity.view(), chart.view()}; }

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

/// Returns the options of the tests: the fit "explained", and dark texels that count as a hundredth.
inline fit::FilteredLightOptions explained() {
    fit::FilteredLightOptions options;
    options.light.fit = fit::DominantFit::Explained;
    options.floor = 0.01;
    return options;
}

}  // namespace lightcook::test
