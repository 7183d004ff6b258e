// Skip records something that a cook leaves out, with the memory and time that this saves.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/pixel_format.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

/// Layers of a texture that a skip saved, as large as its light map.
struct SkippedImages {
    formats::PixelFormat format = formats::PixelFormat::Bc7;
    int layers = 1;
    int side = 1;             ///< formats::LightMapTextureInfo::side
    bool isCoverage = false;  ///< formats::kCoverageRole, which has a size of its own
};
/// Work that a skip saved, whose time is measured by WorkRates.
struct SkippedWork {
    std::string kind = {};  ///< an asset kind
    double texels = 0;      ///< of a light map: known once it is open
};

/// Something that is not cooked, or not cooked again, and the memory and time that this saved.
struct Skip {
    std::string what, why;
    std::string asset = {};  ///< that would have it; empty: an action whose result was reused
    std::uint64_t bytesSaved = 0;
    double secondsSaved = 0;  ///< the time that a reused result took, else that of `work`; NaN if it was never measured
    SkippedWork work = {};
    /// The light map whose size, known once it is open, decides bytesSaved: that of `images` less that of `instead`. Empty if bytesSaved is
    /// known.
    std::string lightMap = {};
    std::vector<SkippedImages> images = {}, instead = {};
};
template <class Fields, Is<Skip> Self>
void describe(Fields& fields, Self& skip) {
    fields.required("what", skip.what, "asset or action");
    fields.required("why", skip.why, "reason");
    fields.presentIf(!skip.asset.empty(), "asset", skip.asset, "name of the asset that would have it; absent for actions");
    fields.required("bytes_saved", skip.bytesSaved, "GPU memory that this saved [bytes]");
    fields.required(
        "seconds_saved", skip.secondsSaved, kNumberOrNull,
        "time that this saved, measured: of a reused result its own, else that of its kind on this machine; null if it was never measured");
}

}  // namespace lightcook::pipeline
