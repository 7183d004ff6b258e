// Verification of a cooked light map: every texel is decoded by the shipped shader (compiled as C++), shaded, and compared with the float
// bake, stage by stage. Errors are sampled, and bounded from above for every normal, view, material and position (docs/theory/bounds.md).
// Layouts are known by their names and constants only: no code is shared with the encoder.
//
// Use, by strips of rows that may be worked on in any order and are merged in a fixed one:
//   1. LightMapKey over the reference                      -> key
//   2. LightMapVerifier::create, verifyRows on each strip  -> LightMapErrors, merged, -> figures()
// LightMapScore compares a light map of any origin, given as coefficients.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/gpu_texture.h"
#include "formats/image.h"
#include "formats/light_map.h"
#include "formats/light_map_detail.h"
#include "formats/light_map_layout.h"
#include "lighting/brdf.h"
#include "verify/figures.h"
#include "verify/seams.h"
#include "verify/tile_errors.h"

namespace lightcook::verify {

/// Detail of a light map, as its manifest describes it: tiles in layout formats::kDetailLayout.
struct CookedDetail {
    std::map<std::string, std::vector<float>> constants;  ///< of that layout
    std::vector<formats::PixelFormat> formats = {};       ///< as CookedLightMap::formats

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.constants, self.formats);
    }
};

/// A light map as its manifest describes it.
struct CookedLightMap {
    std::string layout;                                   ///< a name of formats/light_map_layout.h
    std::map<std::string, std::vector<float>> constants;  ///< as compress::LightMapPlan::constants
    int width = 0, height = 0;                            ///< [texels]
    /// Formats of the textures, in the order of LightMapVerifier::textures(). The bounds then cover the tolerance that graphics APIs give
    /// samplers of these formats. Empty: an ideal sampler.
    std::vector<formats::PixelFormat> formats = {};
    /// Clusters of the blocks of a learned layout, row by row, as its texture "index" holds them. Empty: the constant index_runs.
    std::vector<std::uint8_t> clusterOfBlock = {};
    int clusterBlock = 4;                                                ///< side of these blocks [texels]; 1 at mip levels
    formats::LightMapFilter filter = formats::LightMapFilter::Hardware;  ///< that of the layout, if it has no other
    std::optional<CookedDetail> detail = {};                             ///< of a map whose filter is LightMapFilter::Decoded

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.layout, self.constants, self.width, self.height, self.formats, self.clusterOfBlock, self.clusterBlock, self.filter,
                self.detail);
    }
};

/// Shading of the scene. Samples take every m, every F0 and `viewCount` views (spherical Fibonacci points of the upper hemisphere). The
/// bound covers the whole ranges [min m, max m] x [min F0, max F0] and every view.
struct LightMapShading {
    bool specular = true;
    std::vector<double> m = {0.1, 0.25, 0.5};
    std::vector<double> f0 = {0.04, 0.6};
    int viewCount = 8;
    int normalCount = 32;
    /// Largest angle between a texel's normal and that of a normal map [degrees]: visible errors of diffuse light are those of the cap.
    double normalMapTilt = 60;
    lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann;
    /// Returns false if a surface shows its exit radiance at the texel's own normal alone: no normal maps, no specular light.
    bool needsDirections() const { return specular || normalCount > 1; }

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.specular, self.m, self.f0, self.viewCount, self.normalCount, self.normalMapTilt, self.lobe);
    }
};

/// A verifier computes these figures of a map.
enum class LightMapFigures {
    All,      ///< errors at texel centres and at places on the surface, and bounds
    Sampled,  ///< the same without bounds
    Trial     ///< errors of every stage at places on the surface: none at texel centres, no bounds
};

struct LightMapSampling {
    std::uint64_t seed = 1;
    int placesPerTexel = 1;  ///< random places on the surface of each covered texel, in the mean; 0: none
    LightMapFigures figures = LightMapFigures::All;
    bool isLastStageAlone = false;       ///< a trial of the last stage: earlier ones stay without errors
    std::vector<float> tileLimits = {};  ///< visible errors that tiles are counted by (TileErrors), ascending

    bool hasBounds() const { return figures == LightMapFigures::All; }
    bool isForTrial() const { return figures == LightMapFigures::Trial; }

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.seed, self.placesPerTexel, self.figures, self.isLastStageAlone, self.tileLimits);
    }
};

/// The key of a map: log-average luminance of the reference's exit radiance at the texels' own normals (docs/theory/error.md).
class LightMapKey {
public:
    /// isCoverageKnown  false: the bake does not say which texels lie inside charts, and those without any light count as gaps
    explicit LightMapKey(const glm::vec3& luminanceWeights = lighting::kRec709Luminance, bool isCoverageKnown = true);
    /// Adds rows [firstRow, firstRow + rowCount), which the strip must hold.
    void add(const formats::LightMapStrip& strip, int firstRow, int rowCount);
    void merge(const LightMapKey& other);
    double key() const;  ///< 0 without covered texels
    /// Returns the key that a display is exposed for: the same mean of luminances that are raised to 1/1024 of their mean (docs/theory/
    /// visible.md), so that black texels do not brighten the picture. 0 without covered texels, and for a black map.
    double displayKey() const;
    std::int64_t coveredTexels() const { return sum().texels; }

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.luminanceWeights_, self.isCoverageKnown_, self.bins_);
    }

private:
    /// Luminances that lie close together: their number, and the sum of their logarithms in integer units, which no order of texels
    /// changes.
    struct Bin {
        std::int64_t texels = 0, logSum = 0;
    };
    static constexpr int kBinsPerOctave = 64, kLowestExponent = -40, kHighestExponent = 40;
    Bin sum() const;

    glm::vec3 luminanceWeights_;
    bool isCoverageKnown_;
    std::vector<Bin> bins_;  ///< by log2 of the luminance
};

/// Texels of detail, at their places in the map.
struct DetailTexels {
    formats::Image<std::uint8_t> has = {};                              ///< 1 where the texel's tile has detail
    std::vector<std::vector<formats::Image<glm::vec4>>> textures = {};  ///< [texture][layer] of formats::kDetailLayout
};

/// Rows [firstRow, firstRow + height of the images) of every texture, decoded by decodeRows, in the order of LightMapVerifier::textures().
/// Textures with a `side` have a texel for each square of that side: firstRow is a multiple of it.
struct DecodedLightMapRows {
    int firstRow = 0;
    std::vector<std::vector<formats::Image<glm::vec4>>> textures;  ///< [texture][layer]
    /// blockSpans of each layer, or empty images for formats without them. Decoders may differ in the texels between a block's endpoints.
    std::vector<std::vector<formats::Image<glm::vec4>>> spans = {};  ///< [texture][layer]; empty: no sampler tolerance by span
    /// 1 where texture "coverage" says that a texel is covered: of maps that have it (formats::LightMapFilter::Decoded).
    formats::Image<std::uint8_t> covered = {};
    DetailTexels detail = {};  ///< of maps that have it
};

/// Some rows of a cooked map, and of its bake.
struct LightMapRows {
    const DecodedLightMapRows& texels;
    const formats::LightMapStrip& reference;
};

/// Light at the rim of a chart, where a filter weighs a texel outside the chart most: incident radiance, world frame, no Condon-Shortley
/// sign.
struct RimPlace {
    glm::ivec2 covered{0}, outside{0};  ///< the texel whose surface ends there, and the one beside it
    lighting::ShRgb reference{}, found{};
};

/// Errors of shaded light at some places of a map.
struct ShadedErrors {
    ErrorAccumulator diffuse{1}, specular{1};
    VisibleAccumulator visibleDiffuse, visibleSpecular;  ///< without samples where no viewing was given

    void merge(const ShadedErrors& other);
    ErrorFigures diffuseFigures() const;
    ErrorFigures specularFigures() const;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.diffuse, self.specular, self.visibleDiffuse, self.visibleSpecular);
    }
};

/// Squares of diffuse light, summed over places, all normals of the sphere and channels.
struct DiffuseSquares {
    double error = 0, reference = 0;

    void merge(const DiffuseSquares& other);
    /// Returns the RMS of the error over that of the reference; 0 without light.
    double relRms() const;
};

/// Errors of some rows of a map. As an archive (formats/archive.h) they have no errors of tiles.
class LightMapErrors {
public:
    struct Stage {
        std::string name;
        ShadedErrors errors;
        DiffuseSquares surface = {};  ///< at places on the surface; none in a trial
        TileErrors tiles = {};        ///< of places on the surface, of a trial with LightMapSampling::tileLimits

        template <class Archive, class Self>
        static void members(Archive& archive, Self& self) {
            archive(self.name, self.errors, self.surface);
        }
    };
    explicit LightMapErrors(std::vector<Stage> empty = {}) : stages(std::move(empty)) {}
    void merge(const LightMapErrors& other);
    /// Returns the stages in the order of encoding, then "total", the verdict on the asset: figures of the places on the surface, with
    /// those of texel centres beside them, and maxima and bounds of both. Without such places it has those of the last stage. Seconds are
    /// 0; the caller measures time.
    std::vector<StageError> figures() const;

    std::vector<Stage> stages;  ///< of the layout, at texel centres; in a trial on the surface
    ShadedErrors surface;       ///< of the last stage, at random places on the surface: the footprints of covered texels, to their rims

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.stages, self.surface);
    }
};

/// A rectangle of texels.
struct TexelArea {
    int x = 0, y = 0, width = 0, height = 0;
};

class LightMapVerifier {
public:
    struct TextureNeed {
        std::string name;
        int layerCount = 1;
        int side = 1;  ///< formats::LightMapTextureInfo::side
    };

    /// Creates a verifier. Fails for unknown layouts, constants that are missing, of wrong size or not finite, and a wrong number of
    /// formats.
    /// key      of the reference (LightMapKey)
    /// viewing  empty: no visible errors
    static formats::Result<LightMapVerifier> create(const CookedLightMap& map, const LightMapShading& shading,
                                                    const LightMapSampling& sampling, double key,
                                                    const std::optional<Viewing>& viewing = std::nullopt);
    LightMapVerifier(LightMapVerifier&&) noexcept;
    LightMapVerifier& operator=(LightMapVerifier&&) noexcept;
    ~LightMapVerifier();

    /// Returns the textures of a layout; fails as create does.
    static formats::Result<std::vector<TextureNeed>> texturesOf(const CookedLightMap& map);
    /// Returns the textures of this map's layout.
    const std::vector<TextureNeed>& textures() const;
    /// Returns errors of rows [firstRow, firstRow + rowCount), and of the texel quads that begin in them. If the map has a row below and
    /// places or bounds are asked for, texels and reference must hold that row too. Pure; safe to call from several threads.
    LightMapErrors verifyRows(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, int firstRow, int rowCount) const;
    /// Returns errors between this mip level and the next smaller one, as a trilinear sampler mixes them: at placesPerTexel random places a
    /// texel of the smaller level, in the mean, and random shares of both levels. Pure; safe to call from several threads.
    /// rows         must hold the rows of this level that lie beside those of the smaller one: [2 firstRow, 2 (firstRow + rowCount) + 2)
    /// smaller      verifier of the smaller level, of the same key, shading and viewing
    /// smallerRows  must hold rows [firstRow, firstRow + rowCount) of the smaller level, and the row below
    ShadedErrors verifyBetween(const LightMapRows& rows, const LightMapVerifier& smaller, const LightMapRows& smallerRows, int firstRow,
                               int rowCount) const;
    /// Returns the light of the places at the rims of charts, in the quads that begin in rows [firstRow, firstRow + rowCount). The row
    /// below must be there, too, if the map has one.
    std::vector<RimPlace> rimPlaces(const LightMapRows& rows, int firstRow, int rowCount) const;
    /// Upper bounds of the local error in one quad.
    struct QuadBound {
        double diffuse = 0, specular = 0;
    };
    /// Returns the bounds of the quad whose top left texel is (x, y), as verifyRows merges them into maxBound; x and y may be -1. Its
    /// texels must be in texels and reference.
    QuadBound boundQuad(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, int x, int y) const;
    /// Upper bounds of the visible errors of an area, with their places.
    struct AreaVisibleBound {
        double diffuse = 0, specular = 0;
        VisiblePlace diffuseAt, specularAt;
    };
    /// Returns the bounds of the quads whose top left texels are in an area, as verifyRows merges them into VisibleFigures::bound. Texels
    /// and reference must hold the area and the row below.
    AreaVisibleBound visibleBound(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, const TexelArea& area) const;
    /// Returns errors of no rows, to merge into.
    LightMapErrors noErrors() const;
    /// Returns the coefficients that the shader decodes at the texel centres of rows [firstRow, firstRow + rowCount): world frame, no
    /// Condon-Shortley sign. For layouts of exit radiance they are the constant environment of the same exit radiance.
    ///
    /// placesPerTexel  N: instead at N x N places of each texel, (x + 0.5) / N of the map's coordinates, from filtered texels as a GPU has
    ///                 them. The image has N times the width and rows; `texels` must hold the row above and the row below, too
    /// surface         rows of the bake with tangents, which a layout in tangent space needs; others take none. Its coefficients are
    ///                 exact at the texel's own normal, and near to the shader's light at others
    formats::Image<lighting::ShRgb> reconstruct(const DecodedLightMapRows& texels, int firstRow, int rowCount, int placesPerTexel = 1,
                                                const formats::LightMapStrip* surface = nullptr) const;
    /// Returns some columns of that image, in the order that they are named in.
    formats::Image<lighting::ShRgb> reconstructColumns(const DecodedLightMapRows& texels, int firstRow, int rowCount, int placesPerTexel,
                                                       const formats::LightMapStrip* surface, std::span<const int> columns) const;

    /// Returns the number of lights of a place: that of the bake, and that of each stage of the layout.
    std::size_t lightCount() const;
    /// Stores the light of a place as a GPU filters it, in units of the key: of the bake between covered texels alone, then of the cooked
    /// texels after each stage. Returns false, and stores nothing, if no texel that the filter reaches is covered.
    /// texel  place in the map; integers are texel centres. Texels and reference must hold its row and the row below
    /// light  lightCount() values
    bool lightAt(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, const glm::dvec2& texel,
                 std::span<lighting::ShRgb> light) const;
    /// Returns the steps of light between both sides of these places, which are in the order of their edges. Pure; safe to call from
    /// several threads. Without viewing there are none.
    SeamErrors seamErrors(std::span<const LitSeamPlace> places) const;
    /// Returns errors of no places, to merge into.
    SeamErrors noSeamErrors() const;

private:
    struct State;
    explicit LightMapVerifier(std::unique_ptr<const State> state);
    std::unique_ptr<const State> state_;
};

/// Errors of a light map of any layout, codec or engine against its bake, computed from coefficients at texel centres or other places.
/// Shading and sums are those of LightMapVerifier.
class LightMapScore {
public:
    /// Fails for shading without normals, views, m or F0, or with values out of range.
    /// key      of the reference (LightMapKey)
    /// viewing  empty: no visible errors
    static formats::Result<LightMapScore> create(const LightMapShading& shading, double key,
                                                 const std::optional<Viewing>& viewing = std::nullopt);
    LightMapScore(LightMapScore&&) noexcept;
    LightMapScore& operator=(LightMapScore&&) noexcept;
    ~LightMapScore();

    /// Returns errors of rows [firstRow, firstRow + result.height) of the map, which the reference must hold. Merged in the order of rows
    /// they are the map's errors. Pure; safe to call from several threads.
    /// result  as wide as the reference: incident radiance, world frame, no Condon-Shortley sign
    ShadedErrors score(const formats::LightMapStrip& reference, formats::ImageView<const lighting::ShRgb> result, int firstRow) const;

    /// Incident radiance at a place of the map, as the bake has it and as it was found: world frame, no Condon-Shortley sign.
    struct Place {
        glm::dvec2 texel;  ///< of the map; integers are texel centres
        lighting::ShRgb reference, found;
        glm::vec3 normal;  ///< unit, world frame
    };
    /// Returns errors at some places, wherever they lie.
    ShadedErrors score(std::span<const Place> places) const;

private:
    struct State;
    explicit LightMapScore(std::unique_ptr<const State> state);
    std::unique_ptr<const State> state_;
};

}  // namespace lightcook::verify
