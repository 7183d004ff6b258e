// Light as a display shows it, and the difference of two colours in units of a just noticeable one (docs/theory/visible.md).
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>

namespace lightcook::lighting {

/// Luminance of diffuse white on a display [cd/m^2] (ITU-R BT.2408-7, section 2).
inline constexpr double kDiffuseWhite = 203;
/// Part of diffuse white that the key of a light map is shown at: that of a grey card.
inline constexpr double kKeyOfDiffuseWhite = 0.18;

/// A display that light is shown on.
struct Display {
    double nitsPerUnit = kDiffuseWhite;  ///< luminance of a white with exit radiance 1 [cd/m^2]
    double black = 0.5;                  ///< luminance of black in a dim room, which is added to all light [cd/m^2]
};

/// Settings of the display that an engine shows a scene on.
struct DisplaySettings {
    std::optional<double> white;  ///< exit radiance that is shown as diffuse white; empty: a key is shown at 18 % of diffuse white
    double stops = 0;             ///< exposure compensation: light is shown 2^stops as bright
    double black = 0.5;           ///< luminance of black [cd/m^2]

    /// Returns the display of light with a key. A key of 0, that of a black map, counts as 1.
    Display of(double key) const;
};
inline constexpr double kLeastBlack = 0.005, kMostBlack = 100, kMostStops = 20;  ///< of DisplaySettings
inline constexpr double kLeastWhite = 1e-9, kMostWhite = 1e9;                    ///< of DisplaySettings

/// Largest luminance that PQ codes [cd/m^2]: light above it looks the same (SMPTE ST 2084).
inline constexpr double kMostNits = 10000;

/// Linear BT.2020 from linear Rec.709 (ITU-R BT.2087-0, section 2.2).
glm::dmat3 bt2020FromRec709();

/// LMS of linear BT.2020 (ITU-R BT.2100-2, table 7). Each row sums to 1: white has equal L, M and S.
glm::dmat3 lmsFromBt2020();

/// Returns the inverse EOTF "PQ", in [0, 1], of a luminance [cd/m^2], which is clamped to [0, 10000] (SMPTE ST 2084, ITU-R BT.2100-2).
/// Within 1e-13 of it.
double perceptualQuantizer(double nits);

/// I, T = Ct / 2 and P = Cp of PQ-coded LMS (ITU-R BT.2100-2, table 7; ITU-R BT.2124-0).
glm::dmat3 itpFromLms();
inline constexpr double kVisibleScale = 720;  ///< of Delta E ITP: a distance in ITP of 1/720 is just noticeable (ITU-R BT.2124-0)

/// Returns I, T and P of linear BT.2020 light [cd/m^2] (ITU-R BT.2124-0).
glm::dvec3 ictcpItp(const glm::dvec3& bt2020);

/// Returns the difference Delta E ITP of two exit radiances: 1 is just noticeable under the most critical conditions (ITU-R BT.2124-0).
/// Negative light counts as none. Error: at most 1e-9.
/// bt2020FromWorking  linear BT.2020 from the primaries of a and b
double visibleDifference(const glm::dvec3& a, const glm::dvec3& b, const Display& display,
                         const glm::dmat3& bt2020FromWorking = bt2020FromRec709());

}  // namespace lightcook::lighting
