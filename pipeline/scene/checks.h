// Checks of single settings of a scene.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/light_map.h"
#include "pipeline/document/keys.h"

namespace lightcook::pipeline {

/// Letters of an asset's name: with the endings of its files it stays below the 255 that a file name may have.
inline constexpr std::size_t kLongestName = 128;

/// Returns true for the letters that a name may have. It does not begin with a '.'.
constexpr bool isNameLetter(char letter) {
    return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') || (letter >= '0' && letter <= '9') || letter == '_' ||
           letter == '-' || letter == '.';
}

/// Returns a name with its letters A to Z in lower case. Names that are the same then are one file on Windows and macOS.
std::string inLowerCase(std::string_view name);

/// Returns true for names that no file has on Windows, alone or with an extension: con, prn, aux, nul, com1 to com9 and lpt1 to lpt9, in
/// any case, and names that end in '.' or ' '.
bool isReservedOnWindows(std::string_view name);

/// A limit on visible errors.
inline const KeyRule kVisibleLimit = {.allows = [](double limit) { return limit > 0; },
                                      .expected = "a positive number of just noticeable differences: 2 is hard to see, 10 is plain"};
/// A limit on fireflies.
inline const KeyRule kFireflyLimit = {
    .allows = formats::isFireflyLimit, .expected = "a number from 1, or 0 for no check", .type = "number from 1, or 0"};

/// 1 to 256 increasing Phong exponents from 1 to 65536, one for each row of a reflection map.
Objection objectionToExponents(const std::vector<double>& exponents);
/// An axis is a direction [x, y, z] other than zero.
Objection objectionToAxis(const std::vector<double>& axis);
/// Returns the unit vector of an axis without an objection. Its length may be beyond the range of a double.
glm::dvec3 directionOfAxis(const std::vector<double>& axis);
/// A face of a cubemap has a power of two of texels, so that each level halves the one above.
inline constexpr int kLeastProbeSize = 16, kMostProbeSize = 2048;
Objection objectionToProbeSize(std::int64_t size);
/// A normal map turns normals by at most 1 to 90 degrees from the surface's own.
inline constexpr double kLeastNormalMapTilt = 1, kMostNormalMapTilt = 90;

}  // namespace lightcook::pipeline
