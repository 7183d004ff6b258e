#include "pipeline/scene/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "formats/light_map.h"
#include "lighting/display.h"

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

Objection objectionToFireflyLimit(double limit) {
    if (formats::isFireflyLimit(limit)) return std::nullopt;
    return ValueError{fmt::format("{}", limit), "a number from 1, or 0 for no check"};
}

Objection objectionToRange(const std::vector<double>& range, double lowest, double highest) {
    if (range.size() == 2 && lowest <= range[0] && range[0] <= range[1] && range[1] <= highest) return std::nullopt;
    return ValueError{inBrackets(range), fmt::format("[low, high] with {} <= low <= high <= {}", lowest, highest)};
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

Objection objectionToMaxVisible(double limit) {
    if (limit > 0 && std::isfinite(limit)) return std::nullopt;
    return ValueError{fmt::format("{}", limit), "a positive number of just noticeable differences: 2 is hard to see, 10 is plain"};
}

Objection objectionToWhite(double white) {
    if (white >= lighting::kLeastWhite && white <= lighting::kMostWhite) return std::nullopt;
    return ValueError{fmt::format("{}", white),
                      fmt::format("a positive exit radiance, from {:g} to {:g}", lighting::kLeastWhite, lighting::kMostWhite)};
}

Objection objectionToStops(double stops) {
    if (std::abs(stops) <= lighting::kMostStops) return std::nullopt;
    return ValueError{fmt::format("{}", stops), fmt::format("a number from -{0} to {0}", lighting::kMostStops)};
}

Objection objectionToBlack(double black) {
    if (black >= lighting::kLeastBlack && black <= lighting::kMostBlack) return std::nullopt;
    return ValueError{fmt::format("{}", black),
                      fmt::format("a luminance from {} to {} cd/m^2", lighting::kLeastBlack, lighting::kMostBlack)};
}

Objection objectionToNormalMapTilt(double degrees) {
    if (degrees >= kLeastNormalMapTilt && degrees <= kMostNormalMapTilt) return std::nullopt;
    return ValueError{fmt::format("{}", degrees),
                      fmt::format("an angle from {} to {} degrees, or normal_map = false for surfaces without normal maps",
                                  kLeastNormalMapTilt, kMostNormalMapTilt)};
}

Objection objectionToNormalization(const std::string& normalization, lighting::SpecularLobe lobe) {
    if (normalization == "energy" || formats::info(lobe).distribution) return std::nullopt;
    return ValueError{fmt::format("\"{}\" with the lobe \"{}\"", normalization, formats::info(lobe).name),
                      "\"energy\", the only one of Phong lobes"};
}

Objection objectionToSceneLobe(lighting::SpecularLobe lobe) {
    const formats::SpecularLobeInfo& row = formats::info(lobe);
    if (row.distribution) return std::nullopt;
    return ValueError{fmt::format("\"{}\"", row.name),
                      fmt::format("{}: cubemaps and dominant lights have no Phong lobe (lightcook lut --lobe {} makes tables alone)",
                                  formats::listOfNames(formats::sceneLobes()), row.name)};
}

Objection objectionToTableLobe(lighting::SpecularLobe tables, lighting::SpecularLobe scene) {
    if (tables == scene) return std::nullopt;
    const std::string_view name = formats::info(tables).name;
    return ValueError{fmt::format("\"{}\" beside the scene's lobe \"{}\"", name, formats::info(scene).name),
                      fmt::format("the same lobe: write lobe = \"{}\" above the first table of the scene file", name)};
}

}  // namespace lightcook::pipeline
