// Light-map layouts: how nine RGB SH coefficients a texel (or less, where the scene needs less) lie in GPU textures, stage by stage, and
// the encoder of each. What the shader does with the texels is in shaders/light_map_*.glsl, and only there.
//
//   layout  textures (array layers)                                  decode of the filtered texels              degree
//   raw     "sh" (9: rgb = coefficient i), RGBA16F on every target   lambda_i = range sh_i                           1
//   flat    "exit" (1: rgb)                                          exit radiance at the own normal = range exit    1
//   luvw    "luvw_first" (9), "luvw_second" (9): rgb, a              lambda_i = range_i a0 a1 (uvw0 + uvw1)          3
//   ratio   "l0" (1: rgb), "ratio" (8: rgb, i = 1..8)                lambda_0 = range l0,
//                                                                    lambda_i = lambda_0 (scale_i ratio_i + bias_i)  2
//   luvw-linear: "luvw_first" (5), "luvw_second" (5): rgb, a         the same for i = 0..3 and an intensity I;       not a
//                                                                    lambda_i = I Y_i(axis of band 1) for i = 4..8   polynomial
//   zh3     "l0" (1: rgb), "ratio" (4: rgb, i = 1..4)                lambda_0 and lambda_1..3 as ratio has them;     not a
//                                                                    lambda_2m = lambda_0 (scale_4 ratio_4 + bias_4) polynomial
//                                                                    sqrt(4 pi / 5) Y_2m(axis of band 1)
//   basis-3 "l0" (1: rgb), "code" (1: rgb)                           lambda_i = lambda_0 P_i(code), P quadratic,     3
//   basis-4 "l0" (1: rgb), "code" (1: rgba)                          learned for each cluster of charts
//   basis-8, -12, -16: and "residual" (1, 2, 3: rgba)                + lambda_0 sum_k (residual_k - neutral) R_ki    3
//
// Use: one LightMapMeasure over every band of the map (bands in any cut), a plan from it, then every band of whole block rows encoded on
// its own. Layouts that learn look at the map twice: LightMapBlocks beside the measure, then LightMapSamples of the blocks chosen. The
// bytes do not depend on how the map was cut. Pure: no thread, no file. Sources: Hu 2008, Lightmap compression in Halo 3 (the two-texture
// L, uvw form); Chen and Liu 2008, Lighting and Material of Halo 3.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compress/encode.h"
#include "formats/chart_clusters.h"
#include "formats/light_map.h"
#include "formats/light_map_layout.h"
#include "formats/pixel_format.h"
#include "formats/target.h"

namespace lightcook::compress {

/// Map-wide statistics that the plan's constants come from. Only covered texels count.
class LightMapMeasure {
public:
    /// luminanceWeights  of the working colour space
    explicit LightMapMeasure(const glm::vec3& luminanceWeights = lighting::kRec709Luminance);
    /// Rows [firstRow, firstRow + rowCount) of the map, which the band must hold.
    void add(const formats::LightMapStrip& band, int firstRow, int rowCount);
    void add(const formats::LightMapStrip& band) { add(band, band.firstRow, band.sh.height()); }
    void merge(const LightMapMeasure& other);

    std::int64_t coveredTexels() const { return coveredTexels_; }
    /// Log-average luminance of the exit radiance at the texels' own normals, as product.md defines it; 0 for a map without covered texels.
    double key() const;
    /// Largest absolute value of coefficient i, over channels.
    float maximumAbsolute(int coefficient) const { return maximumAbsolute_[static_cast<std::size_t>(coefficient)]; }
    /// Extremes of lambda_i / lambda_0 over texels and channels whose lambda_0 is positive, bounded by 1.25 sqrt(2l + 1): beyond that a
    /// ratio is noise over almost nothing.
    float minimumRatio(int coefficient) const { return minimumRatio_[static_cast<std::size_t>(coefficient)]; }
    float maximumRatio(int coefficient) const { return maximumRatio_[static_cast<std::size_t>(coefficient)]; }
    /// What layouts "luvw-linear" and "zh3" store of band 2, about the axis of the map's own band 1: the largest intensity, and the
    /// extremes of the zonal coefficient over lambda_0, bounded as the ratios of band 2 are.
    float maximumIntensity() const { return maximumIntensity_; }
    float minimumZonal() const { return minimumZonal_; }
    float maximumZonal() const { return maximumZonal_; }
    const glm::vec3& luminanceWeights() const { return luminanceWeights_; }
    /// Largest channel of the exit radiance at the texel's own normal.
    float maximumExit() const { return maximumExit_; }
    /// Covered texels and channels where |band 1| > sqrt 3 lambda_0 or |band 2| > sqrt 5 lambda_0 (0.1 % spared for rounding): light that
    /// would have to be negative somewhere. Reported, not repaired.
    std::int64_t beyondPositiveBounds() const { return beyondPositiveBounds_; }

private:
    void addTexel(const lighting::ShRgb& sh, const glm::vec3& normal);
    void addZonal(const lighting::ShRgb& sh);

    glm::vec3 luminanceWeights_;
    std::int64_t coveredTexels_ = 0, beyondPositiveBounds_ = 0;
    std::int64_t logLuminanceSum_ = 0;  ///< in units of 2^-24: whole numbers add up to the same sum in any order
    float maximumExit_ = 0, maximumIntensity_ = 0, minimumZonal_ = 0, maximumZonal_ = 0;
    std::array<float, lighting::kShCount> maximumAbsolute_{}, minimumRatio_{}, maximumRatio_{};
};

/// Rows beyond the encoded ones that encodeLightMapRows looks at to fill texels outside charts.
inline constexpr int kLightMapPaddingRows = 2;

// Learned layouts: a light map by its 4 x 4 blocks, and a sample of blocks to learn from.

/// Texels of a side of the blocks that charts are told apart by.
inline constexpr int kChartBlock = formats::kClusterBlock;

class LightMapBlocks {
public:
    LightMapBlocks() = default;
    /// [texels]
    LightMapBlocks(int width, int height);
    /// Rows [firstRow, firstRow + rowCount) of the map, whole blocks but at its end, which the band must hold. Different rows may be added
    /// from several threads.
    void add(const formats::LightMapStrip& band, int firstRow, int rowCount);

    int across() const { return across_; }
    int count() const { return static_cast<int>(covered_.size()); }
    /// A chart for each block, numbered in the order of their first blocks; -1 without covered texels. Covered texels that touch, by a
    /// corner too, and texels of one block are one chart: no filter reaches from one into another.
    /// islands  of meshes that read the map: all blocks that one holds texel centres of, and all covered texels that it is filtered from,
    ///          are one chart, however narrow what joins them. Blocks of texel centres have a chart although nothing in them is covered.
    std::vector<int> charts(std::span<const formats::IslandRun> islands = {}) const;
    /// About `budget` blocks, ascending: a quarter of them by covered area, a quarter by light, half by charts, each after the root of its
    /// light; at least one of every chart, spread evenly over it. charts: of this map
    struct Choice {
        int block;
        float weight;  ///< how many blocks this one stands for
    };
    std::vector<Choice> choose(const std::vector<int>& charts, int budget) const;

private:
    /// Calls visit(block) for blocks of a run: with a covered texel in it, or all where their centres lie inside the island.
    template <class Visit>
    void forEachBlock(const formats::IslandRun& run, Visit visit) const;

    int across_ = 0, width_ = 0, height_ = 0;
    std::vector<std::uint16_t> covered_;  ///< bit 4 y + x
    std::vector<double> light_;           ///< sum of squared coefficient 0
};

/// Chosen blocks with their surroundings, side by side in a band of their own: what lies beside a block's texels decides how it is padded.
class LightMapSamples {
public:
    LightMapSamples() = default;
    LightMapSamples(std::vector<LightMapBlocks::Choice> choices, int across);
    /// Takes the chosen blocks of rows [firstRow, firstRow + rowCount) of the map, whole blocks but at its end. The band must hold those
    /// rows and kLightMapPaddingRows more on either side where the map has them. Different rows may be added from several threads.
    void add(const formats::LightMapStrip& band, int firstRow, int rowCount);

    const std::vector<LightMapBlocks::Choice>& choices() const { return choices_; }
    /// kSide rows; the texels of choice i are rows and columns [kMargin, kMargin + kChartBlock) of its columns, kSide i and on.
    const formats::LightMapStrip& texels() const { return texels_; }
    static constexpr int kMargin = kLightMapPaddingRows, kSide = kChartBlock + 2 * kMargin;

private:
    int across_ = 0;
    std::vector<LightMapBlocks::Choice> choices_;
    formats::LightMapStrip texels_;
};

/// One texture of a layout: a 2-D array of layerCount layers (a plain texture where layerCount is 1), as large as the map.
struct LightMapTexture {
    std::string name;
    formats::PixelFormat format = formats::PixelFormat::Rgba16f;
    int layerCount = 1;
};

struct BasisModel;

/// All that is decided before the first block is encoded, and all that a decoder needs.
struct LightMapPlan {
    formats::LightMapLayout layout = formats::LightMapLayout::Raw;
    formats::Target target = formats::Target::Float;
    int width = 0, height = 0;  ///< [texels]
    std::vector<LightMapTexture> textures;
    std::map<std::string, std::vector<float>> constants;  ///< by the names of the members of the shader's constants
    double key = 0;                           ///< of the measure: the encoders' errors are relative above 0.02 key and absolute below
    std::shared_ptr<const BasisModel> basis;  ///< of layouts that learn; constants hold the same
    bool isClusterInMesh = false;             ///< vertices bear the cluster, so that no index by blocks is needed in GPU memory

    int blockHeight() const;       ///< [texels] cuts between bands must lie on multiples of it
    double bitsPerTexel() const;   ///< all textures and layers, tables included
    std::size_t gpuBytes() const;  ///< the same in bytes
    /// The same for a layout that is this one, or this one without the last layers of its residual.
    std::size_t gpuBytesAs(formats::LightMapLayout shorter) const;
    std::size_t tableBytes() const;  ///< what a learned decode needs beside its textures
};

/// layout: one that does not learn
LightMapPlan planLightMap(formats::LightMapLayout layout, formats::Target target, int width, int height, const LightMapMeasure& measure);
/// layout    one that learns
/// blocks    of the whole map; charts: blocks.charts()
/// samples   of blocks.choose(charts, ...), filled from the whole map
/// clusters  at most so many bases, 1 .. 256; 0: as many as cost an eighth of l0 and code, at most 64
LightMapPlan planLearnedLightMap(formats::LightMapLayout layout, formats::Target target, int width, int height,
                                 const LightMapMeasure& measure, const LightMapBlocks& blocks, const std::vector<int>& charts,
                                 const LightMapSamples& samples, int clusters, const EncodeOptions& options);
/// Blocks worth learning from, for LightMapBlocks::choose: more for maps of more than a megapixel, up to four times as many.
int learningBlocks(int effort, int width, int height);

/// The same luvw plan with the constants of Halo 3 (residual span 1, square roots, no headroom): the yardstick that the default is measured
/// against. Decoders need nothing new. luvw: a plan of layout Luvw.
LightMapPlan withHalo3Constants(LightMapPlan luvw);

/// The blocks of some rows of every texture: textures[t].layers[l] holds whole rows of blocks, in the order of plan.textures.
struct EncodedLightMapTexture {
    std::vector<std::vector<std::byte>> layers;
};
struct EncodedLightMapRows {
    std::vector<EncodedLightMapTexture> textures;
    EncodeReport report;
};

/// Encodes the rows [firstRow, firstRow + rowCount) of the map.
/// band      holds those rows and kLightMapPaddingRows more on either side where the map has them (more is allowed): with less the
///           result would depend on the cut, so that is a broken promise (assert)
/// firstRow  a multiple of plan.blockHeight(); so is rowCount, except at the map's end
/// options   effort; the metric, its scale and the weights are chosen here
/// Texels outside charts within two texels of a chart take the mean of their nearest covered neighbours and weigh next to nothing; all
/// others weigh nothing. Values that do not fit (negative L0 in an unsigned format, ratios beyond the plan's range) are counted in the
/// report.
EncodedLightMapRows encodeLightMapRows(const LightMapPlan& plan, const formats::LightMapStrip& band, int firstRow, int rowCount,
                                       const EncodeOptions& options);

}  // namespace lightcook::compress
