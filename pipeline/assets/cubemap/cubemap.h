// Environment probes as prefiltered cubemaps, pre-divided or plain: docs/theory/lighting.md, "Pre-divided cubemaps".
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "formats/target.h"
#include "lighting/sh.h"
#include "pipeline/assets/textures.h"
#include "pipeline/assets/verification.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Parameters of the cook action. Its inputs are "source" (one file or the first of six) and optionally "sh".
struct CubemapParameters {
    formats::ColorSpaces colors;
    formats::Target target = formats::Target::Bc;
    TextureSettings textures;
    int size = 0;        ///< of a face at level 0 of the whole chain [texels]
    int firstLevel = 0;  ///< of the chain: the levels before it are left out, since no material reads them
    std::string layout;  ///< a name of allCubemapLayouts()
    bool repair = false;
    lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann;
    std::optional<std::string> probeFile;  ///< name by which input "sh" knows the probe
    formats::ProbePlace place = {};        ///< goes before that of input "sh"
};
template <class Fields, Is<CubemapParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("colors", parameters.colors, "colour spaces");
    fields.required("target", parameters.target, "target");
    fields.required("textures", parameters.textures, "settings of the files");
    fields.required("size", parameters.size, "texels along an edge");
    fields.presentIf(parameters.firstLevel > 0, "first_level", parameters.firstLevel, "first level of the chain that is made");
    fields.required("layout", parameters.layout, "layout of the texels");
    fields.required("repair", parameters.repair, "true to replace texels that are not finite");
    fields.required("lobe", parameters.lobe, "microfacet distribution of the prefilter");
    fields.optional("probe_file", parameters.probeFile, "name of the probe in the SH file");
    fields.presentIf(parameters.place.isKnown(), "place", parameters.place, "place of the probe");
}

/// Constants of the shader's decode. Pre-divided: light = range * texel * S, with S the area specular of `windowed_sh` under the bands of
/// the mip. Prefiltered: light = range * texel; without the members from `windowed_sh` on.
struct CubemapConstants {
    struct Mip {
        double perceptualRoughness = 0, m = 0;
        lighting::ShBands bands{1, 1, 1};
    };
    float range = 1;
    lighting::NormalDistribution kernel = lighting::NormalDistribution::Beckmann;
    std::vector<Mip> mips;
    int firstLevel = 0;  ///< of the whole chain, whose level k of n has perceptual roughness k / (n - 1)
    lighting::ShRgb windowedSh{};
    lighting::ShBands window{1, 1, 1};
    double windowLambda = 0, epsilon = 0;

    bool isDivided() const { return epsilon > 0; }
};
template <class Fields, Is<CubemapConstants::Mip> Self>
void describe(Fields& fields, Self& mip) {
    fields.required("perceptual_roughness", mip.perceptualRoughness, "roughness by which an engine picks the mip");
    fields.required("m", mip.m, "roughness of the kernel: the square of perceptual_roughness");
    fields.required("bands", mip.bands, "factors of SH bands 0, 1 and 2 under this kernel");
}
template <class Fields, Is<CubemapConstants> Self>
void describe(Fields& fields, Self& constants) {
    fields.required("range", constants.range, "factor of the stored texels");
    fields.required("kernel", constants.kernel, "microfacet distribution of the prefilter");
    fields.required("mips", constants.mips, "kernel of each mip");
    fields.presentIf(constants.firstLevel > 0, "first_level", constants.firstLevel,
                     "number of larger levels that no material reads and that are left out");
    fields.presentIf(constants.isDivided(), "windowed_sh", constants.windowedSh, "SH of the denominator");
    fields.presentIf(constants.isDivided(), "window", constants.window, "window of the bands that keeps the denominator positive");
    fields.presentIf(constants.isDivided(), "window_lambda", constants.windowLambda, "lambda of that window; 0: none");
    fields.presentIf(constants.isDivided(), "epsilon", constants.epsilon, "least denominator, over its mean");
}

/// Parameters of the verification.
struct CubemapVerifyParameters {
    VisibleParameters visible;
    std::optional<double> smoothest;  ///< least m of a material; the first level has at most that. Absent where no level is left out
    int unreadLevels = 0;             ///< largest levels that are there and that no material reads
};
template <class Fields, Is<CubemapVerifyParameters> Self>
void describe(Fields& fields, Self& parameters) {
    describe(fields, parameters.visible);
    fields.optional("smoothest", parameters.smoothest, "least roughness m of a material, which the first level must hold");
    fields.presentIf(parameters.unreadLevels > 0, "unread_levels", parameters.unreadLevels,
                     "largest levels that no material reads: no part of the light that a pixel shows");
}

/// Cooks a probe.
formats::Result<ActionOutcome> cookCubemap(const ActionContext& context);
/// Verifies a cooked cubemap against a brute-force prefilter of its source.
formats::Result<ActionOutcome> verifyCubemap(const ActionContext& context);

}  // namespace lightcook::pipeline
