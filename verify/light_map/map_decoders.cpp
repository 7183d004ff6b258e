// MapDecoder of each layout.
#include <utility>
#include <variant>

#include "verify/light_map/basis_coarse_bound.h"
#include "verify/light_map/coarse_bound.h"
#include "verify/light_map/curvature.h"
#include "verify/light_map/deviation.h"
#include "verify/light_map/map_decoder.h"

namespace lightcook::verify::lightmap {

namespace {

/// Learned layouts: each cluster has a decode.
template <class Layout>
concept Learned = requires {
    Layout::kCodeCount;
};

template <class Layout>
class LayoutDecoder final : public MapDecoder {
public:
    LayoutDecoder(const Layout& layout, float perKey)
        : MapDecoder(formats::info(Layout::kLayout), Layout::kLayers, perKey), layout_(layout) {
        if constexpr (Learned<Layout>) tables_ = layout.tables.get();
        if constexpr (layouts::FlatFamily<Layout>) isOwnNormalOnly_ = layout.isOwnNormalOnly;
        if constexpr (layouts::InTangentSpace<Layout>) frames_ = &layout.frames;
    }

    LcSh decode(LayerTexels texels, std::size_t cluster) const override {
        return scaled(decodeOf(cluster).decode(layersOf(texels)), perKey());
    }
    void decodeStages(LayerTexels texels, [[maybe_unused]] const LcSh& reference, std::size_t cluster, std::span<LcSh> out) const override {
        if constexpr (Layout::kStages > 1) {
            typename Layout::Stages light;
            decodeOf(cluster).decodeStages(layersOf(texels), scaled(reference, 1 / perKey()), light);
            for (std::size_t stage = 0; stage < light.size(); ++stage) out[stage] = scaled(light[stage], perKey());
        } else {
            out[0] = decode(texels, cluster);
        }
    }
    glm::vec3 exitRadiance([[maybe_unused]] LayerTexels texels, [[maybe_unused]] std::size_t cluster,
                           [[maybe_unused]] const glm::vec3& normal) const override {
        if constexpr (layouts::InTangentSpace<Layout>)
            return perKey() * layout_.at(cluster).exitRadiance(layersOf(texels), normal);
        else
            return {};
    }
    LcSh directions([[maybe_unused]] LayerTexels texels, [[maybe_unused]] std::size_t cluster) const override {
        LcSh out{};
        if constexpr (layouts::InTangentSpace<Layout>) {
            const bool isMirrored = layout_.frames.strip->tangent.texels()[cluster].w < 0;
            for (std::size_t i = 0; i < 3; ++i) out.c[i] = perKey() * glm::vec3(texels[isMirrored && i > 0 ? 3 - i : i]);
        }
        return out;
    }
    BandLengths decodersDiffer(const QuadTexels&) const override { return {}; }
    glm::vec3 besideSh([[maybe_unused]] const QuadTexels& corners) const override {
        if constexpr (layouts::InTangentSpace<Layout>) {
            Texels largest;
            for (std::size_t layer = 0; layer < largest.size(); ++layer)
                largest[layer] = layouts::detail::largestOf(layouts::detail::layerAt(corners, layer));
            return layouts::besideOf(layout_, largest);
        } else {
            return {};
        }
    }
    Deviation deviation([[maybe_unused]] std::span<const TexelBox> boxes, [[maybe_unused]] std::size_t cluster) const override {
        if constexpr (Learned<Layout>)
            return layouts::deviationOf<Layout::kCodeCount>(*layout_.tables, cluster, boxes);
        else if constexpr (layouts::InTangentSpace<Layout>)
            return {layouts::deviationOf(layout_, cluster, boxes.template first<Layout::kLayers>()), {}};
        else
            return {layouts::deviationOf(layout_, boxes.template first<Layout::kLayers>()), {}};
    }
    LcSh curvature([[maybe_unused]] const QuadTexels& corners) const override {
        if constexpr (layouts::Curved<Layout>)
            return layouts::curvatureOf(layout_, corners);
        else
            return {};
    }
    std::unique_ptr<const CoarseBounds> coarseBounds([[maybe_unused]] const std::vector<FormatTolerance>& formats) const override {
        if constexpr (layouts::DecodedBeforeFilter<Layout>)
            return nullptr;
        else if constexpr (Learned<Layout>)
            return std::make_unique<layouts::BasisCoarseBounds<Layout::kCodeCount>>(*layout_.tables, formats);
        else
            return std::make_unique<layouts::CoarseBoundsOf<Layout>>(layout_, formats);
    }

private:
    using Texels = layouts::Texels<Layout::kLayers>;

    static Texels layersOf(LayerTexels texels) {
        Texels out;
        std::copy_n(texels, out.size(), out.begin());
        return out;
    }
    decltype(auto) decodeOf([[maybe_unused]] std::size_t cluster) const {
        if constexpr (Learned<Layout>)
            return typename Layout::Decode{layout_.tables.get(), cluster};
        else if constexpr (layouts::InTangentSpace<Layout>)
            return layout_.at(cluster);
        else
            return (layout_);
    }

    const Layout& layout_;
};

/// Light of texels: any mix of it is between theirs.
class MixBounds final : public CoarseBounds {
public:
    explicit MixBounds(const MapDecoder& decoder) : decoder_(decoder) {}
    bool isKnown() const override { return true; }
    CoarseBound bound(const QuadTexels& corners, std::size_t, const QuadTolerance&) const override {
        BandLengths lengths = decoder_.decodersDiffer(corners);
        for (float& length : lengths) length *= kOutwardFloat / decoder_.perKey();
        return {{}, lengths};
    }

private:
    const MapDecoder& decoder_;
};

class MixedDecoder final : public MapDecoder {
public:
    MixedDecoder(std::shared_ptr<const MapDecoder> ofTexels, std::shared_ptr<const MapDecoder> ofDetail)
        : MapDecoder(ofTexels->info(), mixedLayers(ofTexels->info()), ofTexels->perKey()) {
        degree_ = 1;
        isOwnNormalOnly_ = ofTexels->isOwnNormalOnly();
        ofTexels_ = std::move(ofTexels);
        ofDetail_ = std::move(ofDetail);
    }
    LcSh decode(LayerTexels texels, std::size_t) const override { return lightAt(texels); }
    void decodeStages(LayerTexels texels, const LcSh&, std::size_t, std::span<LcSh> out) const override {
        for (std::size_t stage = 0; stage < stages(); ++stage) out[stage] = lightAt(texels + lighting::kShCount * (stages() - 1 - stage));
    }
    glm::vec3 exitRadiance(LayerTexels, std::size_t, const glm::vec3&) const override { return {}; }
    LcSh directions(LayerTexels, std::size_t) const override { return {}; }
    Deviation deviation(std::span<const TexelBox>, std::size_t) const override { return {}; }
    LcSh curvature(const QuadTexels&) const override { return {}; }
    BandLengths decodersDiffer(const QuadTexels& corners) const override {
        BandLengths largest{};
        for (const LayerTexels texels : corners)
            for (int l = 0; l < 3; ++l)
                for (int c = 0; c < 3; ++c) {
                    float& length = largest[static_cast<std::size_t>(3 * l + c)];
                    length = std::max(length, texels[layers() - 3 + static_cast<std::size_t>(l)][c]);
                }
        return largest;
    }
    glm::vec3 besideSh(const QuadTexels&) const override { return {}; }
    std::unique_ptr<const CoarseBounds> coarseBounds(const std::vector<FormatTolerance>&) const override {
        return std::make_unique<MixBounds>(*this);
    }

private:
    static LcSh lightAt(LayerTexels texels) {
        LcSh sh;
        for (std::size_t i = 0; i < lighting::kShCount; ++i) sh.c[i] = glm::vec3(texels[i]);
        return sh;
    }
};

}  // namespace

std::unique_ptr<const MapDecoder> mapDecoder(const layouts::Layout& layout, float perKey) {
    return std::visit(
        [&]<class Layout>(const Layout& each) -> std::unique_ptr<const MapDecoder> {
            return std::make_unique<LayoutDecoder<Layout>>(each, perKey);
        },
        layout);
}

std::shared_ptr<const MapDecoder> mixedDecoder(std::shared_ptr<const MapDecoder> ofTexels, std::shared_ptr<const MapDecoder> ofDetail) {
    return std::make_shared<MixedDecoder>(std::move(ofTexels), std::move(ofDetail));
}

std::shared_ptr<const MapDecoder> tangentDecoder(layouts::Layout layout, float perKey, const formats::LightMapStrip& strip) {
    struct Owner {
        layouts::Layout layout;
        std::unique_ptr<const MapDecoder> decoder;
    };
    auto owner = std::make_shared<Owner>(Owner{std::move(layout), nullptr});
    std::visit(
        [&]<class Layout>(Layout& each) {
            if constexpr (layouts::InTangentSpace<Layout>) each.frames.strip = &strip;
        },
        owner->layout);
    owner->decoder = mapDecoder(owner->layout, perKey);
    return {owner, owner->decoder.get()};
}

}  // namespace lightcook::verify::lightmap
