// The decode of a cooked map, with what the bounds need to know of it, whatever the layout. Private to verify/.
//
// Verification works on this interface and is compiled once. map_decoders.cpp implements it for each layout, from the layout's struct
// (layouts.h), its deviation (deviation.h), curvature (curvature.h) and coarse bound (coarse_bound.h).
#pragma once

#include <algorithm>
#include <array>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "formats/light_map_layout.h"
#include "verify/light_map/layouts.h"
#include "verify/light_map/vectors.h"
#include "verify/sampler_tolerance.h"

namespace lightcook::verify::lightmap {

/// Texels of one place: one of each layer, in the order of the layout's textures.
using LayerTexels = const glm::vec4*;
/// Texels of the corners of a quad or of a rectangle in it, in the order (0, 0), (1, 0), (0, 1), (1, 1).
using QuadTexels = std::array<LayerTexels, 4>;

/// Returns the largest value of a property among all layouts.
template <class Property>
constexpr std::size_t mostOfLayouts(Property property) {
    std::size_t most = 0;
    for (const formats::LightMapLayoutInfo& info : formats::allLightMapLayouts())
        most = std::max(most, static_cast<std::size_t>(property(info)));
    return most;
}
inline constexpr std::size_t kMostStages = mostOfLayouts([](const formats::LightMapLayoutInfo& info) { return info.stages.size(); });
/// Layers of mixedDecoder() for a layout.
constexpr std::size_t mixedLayers(const formats::LightMapLayoutInfo& info) {
    return lighting::kShCount * info.stages.size() + 3;
}
inline constexpr std::size_t kMostLayers = mostOfLayouts(
    [](const formats::LightMapLayoutInfo& info) { return std::max(mixedLayers(info), static_cast<std::size_t>(info.layerCount())); });
inline constexpr std::size_t kMostDegree = mostOfLayouts([](const formats::LightMapLayoutInfo& info) { return info.decodeDegree; });

/// Filtered texels of a place: those beyond the layers of the layout are not set.
using FilteredTexels = std::array<glm::vec4, kMostLayers>;

/// Coarse bound of a quad, light in the units of its texels.
struct CoarseBound {
    BandLengths curvature{};  ///< distance of the control vectors from the bilinear blend of the corners' decodes
    BandLengths tolerance{};  ///< deviation by the sampler tolerance
};

class QuadTolerance;

/// Coarse bounds of the quads of a map (coarse_bound.h).
class CoarseBounds {
public:
    virtual ~CoarseBounds() = default;
    /// Returns false if the formats are outside the bound's assumptions: then there is no coarse bound.
    virtual bool isKnown() const = 0;
    /// Returns the bound under the decode of a cluster.
    /// tolerance  that of the layers' texels in this quad
    virtual CoarseBound bound(const QuadTexels& corners, std::size_t cluster, const QuadTolerance& tolerance) const = 0;
    /// Returns a bound that is faster and looser, if the layout has one.
    virtual std::optional<CoarseBound> quickBound(const QuadTexels&, std::size_t) const { return std::nullopt; }
};

/// A deviation by coefficient and channel: at most `absolute` in each, plus, for each group, the sum of its four vectors, each times any
/// number in [-1, 1]. A group is a texel, its vectors are those of the texel's four channels. Only learned layouts have groups.
struct Deviation {
    LcSh absolute{};
    std::vector<std::array<LcSh, 4>> groups;
};

/// The decode of each texel. Learned layouts have one decode for each cluster of texels, layouts in tangent space one for each texel;
/// others have cluster 0 alone.
class MapDecoder {
public:
    virtual ~MapDecoder() = default;
    MapDecoder(const MapDecoder&) = delete;
    MapDecoder& operator=(const MapDecoder&) = delete;

    const formats::LightMapLayoutInfo& info() const { return info_; }
    std::size_t layers() const { return layers_; }
    /// Degree of the decode as a polynomial of the filtered texels. Curved layouts: 1, which they are near to.
    int degree() const { return degree_; }
    /// Control vectors along each axis of a quad.
    std::size_t nodes() const { return static_cast<std::size_t>(degree_) + 1; }
    std::size_t stages() const { return info_.stages.size(); }
    /// The decode is no polynomial of the texels at all (layouts::Curved).
    bool isCurved() const { return info_.decodeDegree == 0; }
    /// There are several clusters, and deviations have groups.
    bool isLearned() const { return tables_ != nullptr; }
    /// Clusters have decodes of their own: the layout is learned, or in tangent space.
    bool hasClusters() const { return isLearned() || isInTangentSpace(); }
    /// Diffuse light is exitRadiance(), which is at most besideSh() from what the decode shows (layouts::InTangentSpace).
    bool isInTangentSpace() const { return frames_ != nullptr; }
    /// The layers are light that ofTexels() decoded. A place mixes that of covered texels alone (mixedDecoder).
    bool isMixed() const { return ofTexels_ != nullptr; }
    const MapDecoder* ofTexels() const { return ofTexels_.get(); }
    /// Returns the decoder of detail, in whose tiles the light of the last stage is that of detail. Null: none
    const MapDecoder* ofDetail() const { return ofDetail_.get(); }
    /// The map is compared with the exit radiance at each texel's own normal (layouts::Flat).
    bool isOwnNormalOnly() const { return isOwnNormalOnly_; }
    /// 1 / key: converts light to units of the key.
    float perKey() const { return perKey_; }
    std::size_t clusterAt(int x, int y) const {
        if (frames_ != nullptr) return frames_->clusterAt(x, y);
        return tables_ == nullptr ? 0 : tables_->clusterAt(x, y);
    }
    /// Returns true if two clusters have the same decode.
    bool hasSameDecode(std::size_t a, std::size_t b) const { return a == b || (frames_ != nullptr && frames_->at(a) == frames_->at(b)); }

    // Light of texels in units of the key.
    virtual LcSh decode(LayerTexels texels, std::size_t cluster) const = 0;
    /// Sets the light after each stage, the last of which is the decode. Earlier ones may take coefficients from the reference.
    virtual void decodeStages(LayerTexels texels, const LcSh& reference, std::size_t cluster, std::span<LcSh> out) const = 0;
    /// Layouts in tangent space: returns what a white surface with a normal in world axes shows.
    virtual glm::vec3 exitRadiance(LayerTexels texels, std::size_t cluster, const glm::vec3& normal) const = 0;
    /// Layouts in tangent space: returns the light of the directions as coefficients 0 to 2, in the right-handed frame of tangent and
    /// normal.
    virtual LcSh directions(LayerTexels texels, std::size_t cluster) const = 0;

    // Light in the units of the map.
    /// Returns the deviation of decode().
    /// boxes  one for each layer
    virtual Deviation deviation(std::span<const TexelBox> boxes, std::size_t cluster) const = 0;
    /// Returns the curvature of a curved layout over a rectangle with these corners; 0 for others.
    virtual LcSh curvature(const QuadTexels& corners) const = 0;
    /// Returns upper bounds of the lengths that decoders of blocks may differ by, of light of mixedDecoder() anywhere between these corners
    /// [units of the key]; 0 for others.
    virtual BandLengths decodersDiffer(const QuadTexels& corners) const = 0;
    /// Returns an upper bound of |exitRadiance() - what the decode shows| over the normals of the hemisphere and every place between these
    /// corners, as a change of coefficient 0; 0 for layouts that are not in tangent space.
    virtual glm::vec3 besideSh(const QuadTexels& corners) const = 0;
    /// Returns the coarse bounds, which refer to this object.
    /// formats  tolerance of each layer; empty: an ideal sampler
    virtual std::unique_ptr<const CoarseBounds> coarseBounds(const std::vector<FormatTolerance>& formats) const = 0;

protected:
    MapDecoder(const formats::LightMapLayoutInfo& info, std::size_t layers, float perKey)
        : info_(info), layers_(layers), degree_(std::max(info.decodeDegree, 1)), perKey_(perKey) {}

    const formats::LightMapLayoutInfo& info_;
    std::size_t layers_;
    int degree_;
    float perKey_;
    const layouts::BasisTables* tables_ = nullptr;    ///< learned layouts
    const layouts::TangentFrames* frames_ = nullptr;  ///< layouts in tangent space
    bool isOwnNormalOnly_ = false;
    std::shared_ptr<const MapDecoder> ofTexels_, ofDetail_;  ///< of mixedDecoder()
};

/// Returns the decoder of a map of this layout, which must not be moved while the decoder lives.
/// perKey  1 / key
std::unique_ptr<const MapDecoder> mapDecoder(const layouts::Layout& layout, float perKey);
/// Returns the decoder of light that `ofTexels` decoded: nine layers for each stage, the last stage first, in units of the key, then three
/// of lengths, band by band, of what decoders of blocks may differ by. Mixes of them are the light between texels, without a sampler's
/// tolerance: the weights are floats of the shader.
/// ofDetail  decoder of the tiles that have detail; null: none have
std::shared_ptr<const MapDecoder> mixedDecoder(std::shared_ptr<const MapDecoder> ofTexels, std::shared_ptr<const MapDecoder> ofDetail);
/// Returns the decoder of a layout in tangent space on the texels of a strip, which has their tangents and outlives it.
std::shared_ptr<const MapDecoder> tangentDecoder(layouts::Layout layout, float perKey, const formats::LightMapStrip& strip);

}  // namespace lightcook::verify::lightmap
