// Shared by the tests of this folder: the device, sample places, and the tolerance between two samplers.
//
// A sampler's fractions have at least 8 bits (OpenGL and Direct3D demand no more), rounded or truncated: a filtered value is that of a
// place up to 1/256 texel away along each axis. Formats that decode to 8 bits are rounded to them, before and after the filter.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <random>
#include <stdexcept>

#include "formats/error.h"
#include "tests/samplers/browser_device.h"
#include "tests/samplers/gl_device.h"

namespace lightcook::samplers {

inline constexpr double kFraction = 1.0 / 256;  ///< [texels] error of a sampler's 8-bit fractions

/// One device of each kind for all tests of a process.
template <class Kind>
Device* device(std::string& whyNot) {
    static std::string reason;
    static const std::unique_ptr<Kind> kDevice = Kind::create(reason);
    whyNot = reason;
    return kDevice.get();
}

class Samplers : public testing::Test {
protected:
    void SetUp() override {
        std::string whyNot;
        gl_ = open(whyNot);
        if (gl_ == nullptr) GTEST_SKIP() << "no second opinion: " << whyNot;
    }
    virtual Device* open(std::string& whyNot) const { return device<GlDevice>(whyNot); }
    /// Returns true for a format that the device need not support.
    virtual bool mayLack(const std::string&) const { return false; }
    Device* gl_ = nullptr;
    std::mt19937 random_{7};
    float uniform(double low = 0, double high = 1) {
        return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random_));
    }
    glm::dvec3 direction() {
        std::normal_distribution<double> normal;
        return glm::normalize(glm::dvec3(normal(random_), normal(random_), normal(random_)));
    }
};

/// The same tests on a browser.
template <class Tests>
class InABrowser : public Tests {
protected:
    Device* open(std::string& whyNot) const override { return device<BrowserDevice>(whyNot); }
    /// SwiftShader lacks EXT_texture_norm16.
    bool mayLack(const std::string& format) const override { return format.ends_with("16-unorm"); }
};

/// Largest difference, and largest ratio of difference to tolerance.
struct Agreement {
    double difference = 0, part = 0;
    std::string worst;
    void add(double ours, double theirs, double allowed, const std::string& where) {
        const double d = std::abs(ours - theirs);
        const double p = std::isfinite(d) ? (d == 0 ? 0 : d / std::max(allowed, 1e-30)) : 1e30;
        difference = std::max(difference, d);
        if (p > part) worst = fmt::format("{}: ours {:.9g}, theirs {:.9g}, allowed {:.3g}", where, ours, theirs, allowed);
        part = std::max(part, p);
    }
};

template <class T>
T valueOf(formats::Result<T> result) {
    if (!result) throw std::runtime_error(result.error().line());
    return std::move(*result);
}

/// Returns the largest change of a bilinear sample at uv by the filter's fractions: over the corners of the square of possible places.
template <class Sample>
glm::vec4 filterSlack(const Sample& sample, const glm::dvec2& uv, const glm::dvec2& texel) {
    const glm::vec4 middle = sample(uv);
    glm::vec4 slack(0);
    for (const double x : {-kFraction, kFraction})
        for (const double y : {-kFraction, kFraction}) slack = glm::max(slack, glm::abs(sample(uv + glm::dvec2(x, y) * texel) - middle));
    return slack;
}

}  // namespace lightcook::samplers
