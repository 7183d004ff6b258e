#include "pipeline/scene/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace lightcook::pipeline {
namespace {

std::string inBrackets(const std::vector<double>& values) {
    return fmt::format("[{}]", fmt::join(values, ", "));
}

}  // namespace

std::string inLowerCase(std::string_view name) {
    std::string lower(name);
    for (char& letter : lower)
        if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
    return lower;
}

bool isReservedOnWindows(std::string_view name) {
    if (name.ends_with('.') || name.ends_with(' ')) return true;
    static constexpr std::array<std::string_view, 4> kDevices = {"con", "prn", "aux", "nul"};
    const std::string stem = inLowerCase(name.substr(0, name.find('.')));
    const bool isPort = stem.size() == 4 && (stem.starts_with("com") || stem.starts_with("lpt")) && stem[3] >= '1' && stem[3] <= '9';
    return isPort || std::ranges::find(kDevices, stem) != kDevices.end();
}

Objection objectionToExponents(const std::vector<double>& exponents) {
    bool isUsable = !exponents.empty() && exponents.size() <= 256;
    for (std::size_t i = 0; isUsable && i < exponents.size(); ++i)
        isUsable = exponents[i] >= 1 && exponents[i] <= 65536 && (i == 0 || exponents[i - 1] < exponents[i]);
    if (isUsable) return std::nullopt;
    return ValueError{inBrackets(exponents), "1 to 256 increasing Phong exponents from 1 to 65536"};
}

Objection objectionToAxis(const std::vector<double>& axis) {
    const bool isFinite = std::ranges::all_of(axis, [](double component) { return std::isfinite(component); });
    const bool isZero = std::ranges::all_of(axis, [](double component) { return component == 0; });
    if (axis.size() == 3 && isFinite && !isZero) return std::nullopt;
    return ValueError{inBrackets(axis), "a direction [x, y, z] other than zero"};
}

glm::dvec3 directionOfAxis(const std::vector<double>& axis) {
    // Squares of the components may be 0 or infinite.
    const double largest = std::max({std::abs(axis[0]), std::abs(axis[1]), std::abs(axis[2])});
    return glm::normalize(glm::dvec3(axis[0] / largest, axis[1] / largest, axis[2] / largest));
}

Objection objectionToProbeSize(std::int64_t size) {
    if (size >= kLeastProbeSize && size <= kMostProbeSize && (size & (size - 1)) == 0) return std::nullopt;
    return ValueError{fmt::format("{}", size), fmt::format("a power of two from {} to {}", kLeastProbeSize, kMostProbeSize)};
}

}  // namespace lightcook::pipeline
