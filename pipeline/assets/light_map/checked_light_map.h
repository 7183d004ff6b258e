// A cooked light map beside its bake, and the checks of its verification. Each check adds its figures, violations and pictures to the
// result; verify.cpp has the list, in the order in which they run.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "pipeline/assets/light_map/block_errors.h"
#include "pipeline/assets/light_map/chart_errors.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/unpacked_bake.h"
#include "pipeline/assets/light_map/worst_places.h"
#include "pipeline/assets/lut/light_moments.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/verification.h"
#include "verify/seams.h"

namespace lightcook::pipeline {

/// Figures and pictures of the light that the texels of some strips show.
struct ShownTexels {
    WorstBlock block = {};
    std::vector<verify::LightMapTruthPlace> truthPlaces = {};
    LightMoments light = {};
    WorstTexels worst = {};
    ChartErrors charts = {};
    std::optional<glm::ivec2> otherCoverage = {};  ///< first texel at which texture "coverage" is not that of the bake
    Preview preview = {};
    void merge(const ShownTexels& other) {
        block.merge(other.block);
        light.merge(other.light);
        worst.merge(other.worst);
        charts.merge(other.charts);
        if (!otherCoverage) otherCoverage = other.otherCoverage;
        truthPlaces.insert(truthPlaces.end(), other.truthPlaces.begin(), other.truthPlaces.end());
        preview.merge(other.preview);
    }

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.block, self.truthPlaces, self.light, self.worst, self.charts, self.otherCoverage, self.preview);
    }
};

/// Errors and light of the texels of some strips.
struct TexelErrors {
    verify::LightMapErrors errors;
    ShownTexels shown = {};
    void merge(const TexelErrors& other) {
        errors.merge(other.errors);
        shown.merge(other.shown);
    }
};

/// The bake from before charts were packed. The verdict on a repacked map is against it, and so are key and display.
struct BakeBefore {
    LightMapSource& source;
    UnpackedBake unpacked;
};

/// Passes of a verification end at about these parts of its time: the survey of the bake, and the comparison of all texels.
inline constexpr double kSurveyEnd = 0.04, kTexelsEnd = 0.8;

struct CheckedLightMap {
    const ActionContext& context;
    Stopwatch watch;
    CookedAsset asset;
    LightMapVerifyParameters parameters;
    LightMapSource& bake;
    std::optional<BakeBefore> before;  ///< empty where charts are those of the bake, and for a map of constant light
    double key;
    verify::Viewing viewing;
    CookedLightMapReader cooked;
    GroundTruth truth;
    bool hasMesh;                                    ///< that can be read: the mesh's own actions refuse others
    std::vector<verify::SurfaceTriangle> triangles;  ///< of the mesh
    std::optional<MapCharts> charts;                 ///< of the mesh
    TexelErrors texels;                              ///< of checkTexels()
    VerifyResult result = {};                        ///< its stages come first
    std::vector<RenderedView> seamViews = {};
    std::vector<WorstPlacePicture> worstPlaces = {};

    verify::StageError& total() { return result.verdict.stages.back(); }
    std::vector<verify::Violation>& violations() { return result.verdict.violations; }
    int mipCount() const {
        int count = 1;
        for (const CookedTexture& texture : asset.textures) count = std::max(count, texture.mips);
        return count;
    }
};

/// Compares all texels of the map with the bake.
formats::Result<void> checkTexels(CheckedLightMap& map);
/// Adds the verdict against the bake from before its charts were packed.
formats::Result<void> checkPacking(CheckedLightMap& map);
/// Refuses a block that lost its light, and light outside charts that reaches into them.
formats::Result<void> checkBlocks(CheckedLightMap& map);
/// Refuses a residual stage that adds to the error.
formats::Result<void> checkResiduals(CheckedLightMap& map);
/// Refuses a map over its limit whose layout lacks light that the materials need.
formats::Result<void> checkLayout(CheckedLightMap& map);
/// Adds the errors of the mip levels. Fails if the textures have levels that mix charts.
formats::Result<void> checkMips(CheckedLightMap& map);
/// Adds errors against traced light.
formats::Result<void> checkGroundTruth(CheckedLightMap& map);
/// Adds memory and errors of the charts.
formats::Result<void> checkCharts(CheckedLightMap& map);
/// Adds the charts of few texels that hold a largest visible error.
formats::Result<void> checkSmallCharts(CheckedLightMap& map);
/// Draws the places with the largest visible errors.
formats::Result<void> drawWorstPlaces(CheckedLightMap& map);
/// Adds the seams, and draws the worst. Under a limit, seams that cannot be measured are a violation.
formats::Result<void> checkSeams(CheckedLightMap& map);

}  // namespace lightcook::pipeline
