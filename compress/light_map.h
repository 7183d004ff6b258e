// Light-map layouts: SH coefficients of a map in, blocks of GPU textures out. formats/light_map_layout.h has the table of layouts with
// their textures; shaders/light_map_*.glsl has the decode of each, and docs/theory/layouts.md explains them.
//
//   layout        decode of the filtered texels; lambda_i is coefficient i, capital names are constants of the plan
//   raw           lambda_i = RANGE sh_i
//   flat          exit radiance at the texel's own normal = RANGE exit
//   flat-2        exit radiance at the texel's own normal = RANGE mix(exit, second, SHARE)
//   halo3         lambda_i = RANGE_i a0 a1 uvw, uvw = 2 rgb0 - 1 + 2 rgb1 - 1
//   ratio         lambda_0 = RANGE l0, lambda_i = lambda_0 (SCALE_i ratio_i + BIAS_i)
//   sh4           bands 0 and 1 as ratio; band 2 = 0
//   basis-3 to basis-24
//                 lambda_i = lambda_0 (P_i(code) + sum_k (residual_k - neutral) R_ki), P quadratic, P and R learned for each cluster of
//                 charts; basis-3 and basis-4 have no residual
//   hdr           lambda_0 = RANGE sh_0, lambda_i = RANGE sh_i + BIAS_i lambda_0; hdr-rgb9e5 is the same without blocks
//   hdr-2         as hdr, with mix(sh_i, second_i, SHARE) for sh_i
//   godot         exit radiance = L0 (1 + n . L1), L0 = sh_0, L1 = 8 (sh_i - 1/2) along y, z, x; no constants
//   bakery        exit radiance = L0 (1 + n . L1), L0 = l0, L1 = 4 (l1 - 1/2) along each axis; no constants
//   mono-sh       as bakery, with one L1 for the three colours
//   unreal-hq     exit radiance = (2^LogL - 0.01858136) (rgb0^2 SCALE0 + ADD0) (SH . n + ADD1.a), LogL and SH linear in alphas and rgb1
//   lit           lambda_0 = RANGE l0, lambda_i = rest (SCALE_i rest_i + BIAS_i) + I Y_i(direction), I = RANGE light,
//                 rest = lambda_0 - I Y_0; lit-half and lit-quarter have rest_i at a half and a quarter of the size
//   rnm           exit radiance = sum_i max(0, b_i . n) rnm_i, n in tangent space; no constants. Strips have tangents
// The same with bits a texel and reasons: docs/theory/layouts.md.
//
// Use, for any cut of the map into strips of rows:
//   1. LightMapMeasure over every strip; merge the parts.
//   2. planLightMap. A learned layout needs two more passes first: LightMapBlocks, then LightMapSamples of the blocks chosen.
//   3. encodeLightMapRows for each strip of whole block rows, in any order.
// The bytes do not depend on the cut. Pure: no thread, no file.
// Source of halo3: Hu 2008, Lightmap compression in Halo 3.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "compress/encode.h"
#include "compress/light_map_context.h"
#include "formats/archive.h"
#include "formats/chart_clusters.h"
#include "formats/light_map.h"
#include "formats/light_map_layout.h"
#include "formats/pixel_format.h"
#include "formats/target.h"
#include "lighting/brdf.h"
#include "lighting/display.h"

namespace lightcook::compress {

/// Extremes, over texels, of the best linear functions of the normal whose three colours share a slope: exit radiance = constant
/// (1 + n . slope). "Light" is the largest constant of a texel, "chroma" the three constants over it.
struct SharedExitRange {
    float lowestLight = std::numeric_limits<float>::infinity(), highestLight = 0;
    glm::vec3 lowestChroma{std::numeric_limits<float>::infinity()}, highestChroma{-std::numeric_limits<float>::infinity()};
    glm::vec3 lowestSlope{std::numeric_limits<float>::infinity()}, highestSlope{-std::numeric_limits<float>::infinity()};

    bool isEmpty() const { return lowestLight > highestLight; }
    void merge(const SharedExitRange& other);
};

/// Returns true if the plan of a layout takes LightMapMeasure::sharedExitRange().
constexpr bool needsSharedExit(formats::LightMapLayout layout) {
    return formats::info(layout).family == formats::LightMapFamily::Unreal;
}

/// Statistics of the whole map, from which the plan's constants follow. Only covered texels count.
class LightMapMeasure {
public:
    /// luminanceWeights  of the working colour space
    /// hasSharedExit     measures sharedExitRange(), too. That takes a third of the time, and few layouts need it
    explicit LightMapMeasure(const glm::vec3& luminanceWeights = lighting::kRec709Luminance, bool hasSharedExit = true);
    /// Adds the rows [firstRow, firstRow + rowCount) of the map. The strip must hold them.
    void add(const formats::LightMapStrip& strip, int firstRow, int rowCount);
    void add(const formats::LightMapStrip& strip) { add(strip, strip.firstRow, strip.sh.height()); }
    void merge(const LightMapMeasure& other);

    std::int64_t coveredTexels() const { return coveredTexels_; }
    /// Returns the log-average luminance of the exit radiance at the texels' own normals (docs/theory/error.md, "key"), or 0 for a map
    /// without covered texels.
    double key() const;
    /// Largest absolute value of a coefficient, over texels and channels.
    float maximumAbsolute(int coefficient) const { return maximumAbsolute_[static_cast<std::size_t>(coefficient)]; }
    /// Extremes of lambda_i / lambda_0 over texels and channels whose lambda_0 is positive. Clamped to +-1.25 sqrt(2l + 1): a larger ratio
    /// is the noise of a texel that is almost black.
    float minimumRatio(int coefficient) const { return minimumRatio_[static_cast<std::size_t>(coefficient)]; }
    float maximumRatio(int coefficient) const { return maximumRatio_[static_cast<std::size_t>(coefficient)]; }
    const glm::vec3& luminanceWeights() const { return luminanceWeights_; }
    /// Largest channel of the exit radiance at the texel's own normal.
    float maximumExit() const { return maximumExit_; }
    /// Returns the extremes over the texels whose light is in the octave of leastLight or above; 0: over all. Requires hasSharedExit.
    SharedExitRange sharedExitRange(float leastLight) const;
    /// Count of texels and channels where |band 1| > sqrt 3 lambda_0 or |band 2| > sqrt 5 lambda_0, with 0.1 % for rounding: no
    /// non-negative light has such coefficients. Reported, not repaired.
    std::int64_t beyondPositiveBounds() const { return beyondPositiveBounds_; }

private:
    void addTexel(const lighting::ShRgb& sh, const glm::vec3& normal);
    void addRatios(const lighting::ShRgb& sh, int channel);
    void addSharedExit(const lighting::ShRgb& sh, const glm::vec3& normal);

    glm::vec3 luminanceWeights_;
    bool hasSharedExit_;
    std::int64_t coveredTexels_ = 0, beyondPositiveBounds_ = 0;
    std::int64_t logLuminanceSum_ = 0;  ///< in units of 2^-24: integers add up to the same sum in any order
    float maximumExit_ = 0;
    std::array<float, lighting::kShCount> maximumAbsolute_{}, minimumRatio_{}, maximumRatio_{};
    static constexpr int kLowestOctave = -40, kOctaves = 64;
    static std::size_t octaveOf(float light);
    std::array<SharedExitRange, kOctaves> sharedExit_{};  ///< [octave of the light]
};

/// Number of rings of texels around charts that are padded.
inline constexpr int kLightMapPaddingRows = 2;

/// Side of the blocks of LightMapBlocks [texels]: each belongs to one chart.
inline constexpr int kChartBlock = formats::kClusterBlock;

/// The 4 x 4 blocks of a map, for learned layouts: which texels are covered, how much light they hold, and which chart each block belongs
/// to. Ten bytes a block: a 16384 x 16384 map takes 160 MiB.
class LightMapBlocks {
public:
    LightMapBlocks() = default;
    /// width, height  of the map [texels]
    LightMapBlocks(int width, int height);
    /// Adds the rows [firstRow, firstRow + rowCount) of the map: whole block rows, except at the map's end. The strip must hold them.
    /// Threads may add different rows at once.
    void add(const formats::LightMapStrip& strip, int firstRow, int rowCount);

    int across() const { return across_; }
    int count() const { return static_cast<int>(covered_.size()); }
    /// Returns a chart for each block, numbered in the order of their first blocks; -1 for a block without covered texels.
    /// Covered texels that touch, also by a corner, and texels of one block are one chart: no filter reaches from one chart into another.
    /// These are charts of texels, found without meshes; those of atlas::findCharts() are pieces of meshes.
    /// islands  of the meshes that read the map. An island joins into one chart all blocks with texel centres inside it and all covered
    ///          texels that its filter reads, even if they do not touch. A block with such centres has a chart even if it has no covered
    ///          texels.
    std::vector<int> chartOfBlock(std::span<const formats::IslandRun> islands = {}) const;

    /// A block to learn from.
    struct Choice {
        int block;
        float weight;  ///< how many blocks this one stands for
    };
    /// Returns about `budget` blocks, in ascending order, at least one of every chart, spread evenly over each chart.
    /// A quarter of the budget goes by covered area, a quarter by light, and half by charts, in proportion to the root of a chart's light.
    std::vector<Choice> choose(const std::vector<int>& chartOfBlock, int budget) const;

private:
    /// Calls visit(block) for the blocks of a run with a covered texel in the run; for all its blocks if the run lies inside the island.
    template <class Visit>
    void forEachBlock(const formats::IslandRun& run, Visit visit) const;

    int across_ = 0, width_ = 0, height_ = 0;
    std::vector<std::uint16_t> covered_;  ///< [block] bit 4 y + x
    std::vector<double> light_;           ///< [block] sum of squared coefficient 0
};

/// The chosen blocks of a map, each with a margin of kLightMapPaddingRows texels, side by side in a strip of their own. The margin is
/// needed because texels beside a block decide how it is padded.
class LightMapSamples {
public:
    LightMapSamples() = default;
    LightMapSamples(std::vector<LightMapBlocks::Choice> choices, int blocksAcross);
    /// Copies the chosen blocks of the rows [firstRow, firstRow + rowCount): whole block rows, except at the map's end. The strip must hold
    /// those rows and kLightMapPaddingRows more on either side where the map has them. Threads may add different rows at once.
    void add(const formats::LightMapStrip& strip, int firstRow, int rowCount);

    const std::vector<LightMapBlocks::Choice>& choices() const { return choices_; }
    int blocksAcross() const { return across_; }  ///< of the map
    /// Returns the copied texels, kSide rows of them. Choice i has the columns [kSide i, kSide (i + 1)); its block lies kMargin from each
    /// side of that square.
    const formats::LightMapStrip& texels() const { return texels_; }
    static constexpr int kMargin = kLightMapPaddingRows, kSide = kChartBlock + 2 * kMargin;

private:
    int across_ = 0;
    std::vector<LightMapBlocks::Choice> choices_;
    formats::LightMapStrip texels_;
};

/// Learned layouts minimize the mean square of visible errors (docs/theory/visible.md) on this display, over these shadings of a scene.
struct LightMapObjective {
    lighting::Display display;
    glm::dmat3 bt2020FromWorking = lighting::bt2020FromRec709();  ///< from linear working colours
    double normalMapTilt = 60;                                    ///< largest angle of a normal map's normal from the surface's [degrees]
    bool isSpecular = true;                                       ///< area specular light is shaded, with these materials
    std::vector<double> m = {0.1, 0.25, 0.5};                     ///< roughness
    std::vector<double> f0 = {0.04, 0.6};                         ///< reflectance at normal incidence
    lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.display, self.bt2020FromWorking, self.normalMapTilt, self.isSpecular, self.m, self.f0, self.lobe);
    }
};

/// One texture of a layout: a 2-D array of layerCount layers (a plain texture if layerCount is 1), as large as the map over `side`, with
/// mips.
struct LightMapTexture {
    std::string name;
    formats::PixelFormat format = formats::PixelFormat::Rgba16f;
    int layerCount = 1;
    int side = 1;  ///< formats::LightMapTextureInfo::side

    /// Returns the size of level 0 for a map of this size [texels].
    glm::ivec2 sizeFor(int mapWidth, int mapHeight) const;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.name, self.format, self.layerCount, self.side);
    }
};

struct BasisModel;

/// Everything that is decided before the first block is encoded, and everything that a decoder needs.
struct LightMapPlan {
    formats::LightMapLayout layout = formats::LightMapLayout::Raw;
    formats::Target target = formats::Target::Float;
    int width = 0, height = 0;  ///< of level 0, or of the level that it encodes [texels]
    int mipCount = 1;           ///< mip levels of the textures
    formats::LightMapFilter filter = formats::LightMapFilter::Hardware;
    std::vector<LightMapTexture> textures;
    std::map<std::string, std::vector<float>> constants;  ///< by the names of the members of the shader's constants
    std::optional<LightMapObjective> objective;           ///< empty: errors of shaded light by energy
    double key = 0;                                       ///< of the measure: scale of the encoders' error metrics
    std::shared_ptr<const BasisModel> basis;              ///< of a learned layout; the constants hold the same numbers
    /// GPU memory of the vertex attribute that names the cluster [bytes]; 0: an index by blocks names it.
    std::size_t vertexBytes = 0;

    int blockHeight() const;       ///< [texels] strips must be cut at multiples of it
    double bitsPerTexel() const;   ///< of all textures and layers, tables, and the index or the vertex attribute
    std::size_t gpuBytes() const;  ///< the same in bytes, with all mip levels
    std::size_t layerBytes(const LightMapTexture& texture) const;  ///< of a layer, with all mip levels
    /// The map has a texture "coverage" (formats::kCoverageRole): its filter is LightMapFilter::Decoded.
    bool hasCoverage() const { return filter == formats::LightMapFilter::Decoded; }
    /// Returns the rows of the map above and below some rows that encodeLightMapRows() reads.
    int contextRows() const { return hasCoverage() ? 0 : kLightMapContextRows; }
    std::size_t coverageBytes() const;  ///< of that texture, with all mip levels; 0 without
    /// Returns the plan of a learned layout that is this one without its last residual layers, or this one: the same that
    /// planLearnedLightMap() makes of it.
    LightMapPlan shortenedTo(formats::LightMapLayout shorter) const;
    /// Returns gpuBytes() of a layout that is this one, or this one without its last layers.
    std::size_t gpuBytesAs(formats::LightMapLayout shorter) const;
    std::size_t tableBytes() const { return tableBytesAs(layout); }  ///< of a learned decode's factors: texture "tables"
    std::size_t tableBytesAs(formats::LightMapLayout shorter) const;
    /// Returns the columns of texture "tables" of a learned layout: factors of a cluster. 0 for other layouts.
    int tableColumns() const;
    /// Returns texture "tables": RGBA16F, a row for each cluster. A row holds the code's factors [monomial][coefficient 1 to 8], then those
    /// of the residual [layer][channel][coefficient]; alpha is 0. The constants "code" and "residual" hold the same numbers.
    std::vector<std::byte> tableTexels() const;
    /// Returns the clusters of the blocks of 4 x 4 texels of a learned layout, row by row.
    std::span<const std::uint8_t> clusterOfBlock() const;
    /// Returns this plan for the texels of a mip level, which encodeLightMapRows() takes as a map of its own: same constants and tables.
    /// clusterOfTexel  of a learned layout: the cluster of each texel of the level, row by row. Others: empty
    LightMapPlan ofMip(int level, std::vector<std::uint8_t> clusterOfTexel) const;
    /// Returns clusterOfBlock() as texture "index": RGBA8, four neighbours of a row of blocks in a texel. Half a bit a texel of the map.
    std::vector<std::byte> indexTexels() const;
    std::size_t indexBytes() const;

    /// List all members, in terms of formats/archive.h. Plans that encode alike have the same bytes.
    static void members(formats::ArchiveWriter& archive, const LightMapPlan& self);
    static void members(formats::ArchiveReader& archive, LightMapPlan& self);
};

/// The map that a plan is made for, and its statistics.
struct MeasuredLightMap {
    formats::Target target;
    int width, height;                                          ///< [texels]
    const LightMapMeasure& measure;                             ///< of all rows
    std::optional<LightMapObjective> objective = std::nullopt;  ///< empty: errors of shaded light by energy
    formats::LightMapFilter filter = formats::LightMapFilter::Hardware;
};

/// The samples of a map to which the decode of a learned layout is fitted.
struct LightMapTraining {
    const std::vector<int>& chartOfBlock;  ///< LightMapBlocks::chartOfBlock()
    const LightMapSamples& samples;        ///< of LightMapBlocks::choose(chartOfBlock, learningBlocks(...)), filled from the whole map
    int clusters = 0;  ///< largest number of bases, 1 to 256; 0: as many as cost a sixth of textures "l0" and "code", at most 64
};

/// Plans a layout that is not learned.
LightMapPlan planLightMap(formats::LightMapLayout layout, const MeasuredLightMap& map);

/// Plans a learned layout: fits its decode to a sample of the map, in loops of setParallelLoop() (parallel.h). The result is the same for
/// any number of threads.
LightMapPlan planLearnedLightMap(formats::LightMapLayout layout, const MeasuredLightMap& map, const LightMapTraining& training,
                                 const EncodeOptions& options);

/// Returns the budget for LightMapBlocks::choose: 1000 blocks and 500 for each step of effort, times the map's megapixels, at least once
/// and at most four times.
int learningBlocks(int effort, int width, int height);

/// The blocks of some rows of one texture: layers[l] holds whole rows of blocks.
struct EncodedLightMapTexture {
    std::vector<std::vector<std::byte>> layers;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.layers);
    }
};
struct EncodedLightMapRows {
    std::vector<EncodedLightMapTexture> textures;  ///< in the order of plan.textures
    EncodeReport report;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.textures, self.report);
    }
};

/// Encodes the rows [firstRow, firstRow + rowCount) of the map.
/// strip     holds those rows and at least plan.contextRows() more on either side where the map has them (asserted). With fewer the result
///           would depend on the cut
/// firstRow  a multiple of plan.blockHeight(); so is rowCount, except at the map's end
/// options   only the effort counts: metric, scale and weights are chosen here
/// Uncovered texels of a map with a texture "coverage" have significance 0: nothing reads them. Of others,
/// uncovered texels that touch a covered one are chosen so that a filter shows between texels what the covered texels alone show
/// (light_map/filter_fit.h). Those one texel further take the mean of their nearest covered neighbours. All others have significance 0. The
/// report counts values that do not fit: negative L0 in an unsigned format, and ratios beyond the plan's range.
EncodedLightMapRows encodeLightMapRows(const LightMapPlan& plan, const formats::LightMapStrip& strip, int firstRow, int rowCount,
                                       const EncodeOptions& options);

/// Returns the texels of texture "coverage" for the rows [firstRow, firstRow + rowCount) of a map, which the strip must hold: RGBA8, 8 x 4
/// texels of the map in each (shaders/filter.glsl).
/// firstRow  a multiple of formats::kCoverageRows
std::vector<std::byte> coverageTexels(const formats::LightMapStrip& strip, int firstRow, int rowCount);

}  // namespace lightcook::compress
