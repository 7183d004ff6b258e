// A row of a light map as surfaces show it, in the bake and cooked, and the visible errors between both.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <vector>

#include "formats/light_map.h"
#include "lighting/radiometry.h"
#include "lighting/sh.h"
#include "lighting/sphere.h"
#include "verify/visible.h"

namespace lightcook::pipeline {

/// Light of the texels of a row, at their own normals, in the bake and in the cooked map.
class LitRow {
public:
    LitRow(int width, const verify::Viewing& viewing)
        : display_(viewing, 1),
          count_((static_cast<std::size_t>(width) + kLanes - 1) / kLanes * kLanes),
          reference_(kChannels * count_),
          found_(kChannels * count_),
          shownReference_(kChannels * count_),
          shownFound_(kChannels * count_),
          visible_(count_) {}
    /// Sets a texel from its coefficients.
    void set(int x, const lighting::ShRgb& referenceSh, const lighting::ShRgb& foundSh, const glm::vec3& normal) {
        const glm::vec3 reference = lighting::lambertExitRadiance(referenceSh, normal, glm::vec3(1)).value;
        const glm::vec3 found = lighting::lambertExitRadiance(foundSh, normal, glm::vec3(1)).value;
        for (std::size_t c = 0; c < kChannels; ++c) {
            reference_[c * count_ + static_cast<std::size_t>(x)] = reference[static_cast<int>(c)];
            found_[c * count_ + static_cast<std::size_t>(x)] = found[static_cast<int>(c)];
        }
    }
    /// Computes the visible errors of the texels that were set.
    void compare() {
        display_.apply(reference_.data(), count_, shownReference_.data());
        display_.apply(found_.data(), count_, shownFound_.data());
        verify::visibleDifferences(shownReference_.data(), shownFound_.data(), count_, visible_.data());
    }
    glm::vec3 reference(int x) const { return lightOf(reference_, x); }
    glm::vec3 found(int x) const { return lightOf(found_, x); }
    float visible(int x) const { return visible_[static_cast<std::size_t>(x)]; }

private:
    static constexpr std::size_t kChannels = 3, kLanes = verify::DisplayTransform::kLanes;
    glm::vec3 lightOf(const std::vector<float>& planes, int x) const {
        const auto i = static_cast<std::size_t>(x);
        return {planes[i], planes[count_ + i], planes[2 * count_ + i]};
    }

    verify::DisplayTransform display_;
    std::size_t count_;
    std::vector<float> reference_, found_, shownReference_, shownFound_;  ///< [channel][x]
    std::vector<float> visible_;
};

/// The normals that a normal map can turn to: a cap around the texel's own.
class NormalCap {
public:
    /// tilt  largest angle to the texel's own normal [degrees]
    NormalCap(double tilt, const verify::Viewing& viewing) : lit_(kNormals, viewing) {
        const double span = 1 - std::cos(tilt * std::numbers::pi / 180);
        for (int i = 0; i < kNormals; ++i) {
            const double z = 1 - span * i / (kNormals - 1), r = std::sqrt(std::max(0.0, 1 - z * z)), turn = i * kGoldenAngle;
            normals_[static_cast<std::size_t>(i)] = {r * std::cos(turn), r * std::sin(turn), z};
        }
    }
    /// Returns the largest visible error of a texel over the cap.
    float worst(const lighting::ShRgb& reference, const lighting::ShRgb& found, const glm::vec3& normal) {
        const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(normal));
        for (int i = 0; i < kNormals; ++i) lit_.set(i, reference, found, glm::vec3(frame * normals_[static_cast<std::size_t>(i)]));
        lit_.compare();
        float most = 0;
        for (int i = 0; i < kNormals; ++i) most = std::max(most, lit_.visible(i));
        return most;
    }

private:
    static constexpr int kNormals = 32;
    static constexpr double kGoldenAngle = 2.39996322972865332;
    std::array<glm::dvec3, kNormals> normals_;  ///< z is the texel's own
    LitRow lit_;
};

}  // namespace lightcook::pipeline
