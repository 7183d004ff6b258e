// Channels that are optional in every bake format: coverage.Y (above 0.5 inside a chart), normal.X, normal.Y, normal.Z (world space), and
// chart.Y (from 1 on, the number of the chart whose filter reads the texel; 0 where no filter on a surface reads it).
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

inline constexpr const char* kCoverageChannel = "coverage.Y";
inline constexpr std::array<const char*, 3> kNormalChannels = {"normal.X", "normal.Y", "normal.Z"};
inline constexpr const char* kChartChannel = "chart.Y";
/// Channels that say something of the surface, and not of its light.
inline constexpr std::array<std::string_view, 5> kSurfaceChannels = {kCoverageChannel, kNormalChannels[0], kNormalChannels[1],
                                                                     kNormalChannels[2], kChartChannel};

class SurfaceChannels {
public:
    /// Fails if the image has only one or two of the channels of the normal.
    /// coverage  channel that counts as coverage where there is no coverage.Y: "A" of a picture
    static Result<SurfaceChannels> of(const BakeImage& image, const std::string& coverage = "");

    bool hasCoverage() const { return !coverage_.empty(); }
    /// Returns the channel of coverage. Empty: there is none.
    const std::string& coverageChannel() const { return coverage_; }
    bool hasNormals() const { return hasNormals_; }
    /// Makes room in a strip of `width` x `rowCount` texels for the channels that exist, and appends them to the planes to read.
    void prepare(RawStrip& raw, int width, int rowCount, std::vector<ExrPlane>& planes) const;

private:
    std::string coverage_;
    bool hasNormals_ = false, hasCharts_ = false;
};

}  // namespace lightcook::formats
