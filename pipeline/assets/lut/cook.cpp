#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/common.hpp>

#include "fit/specular_tables.h"
#include "pipeline/assets/lut/lut.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

LutConstants::Axis axisOf(const fit::TableAxis& axis, const fit::AxisMapping& mapping) {
    return {mapping.name, mapping.factors, axis.count, axis.minimum, axis.maximum, axis.coordinateScale, axis.coordinateOffset};
}

/// Sets the mappings of both axes: those of the parameters, or where one is "auto" the pair of least error.
void chooseAxes(const LutParameters& parameters, fit::SpecularTableOptions& options) {
    if (parameters.viewAxis == "auto" || parameters.roughnessAxis == "auto")
        fit::chooseMappings(options, parameters.f0[0], parameters.f0[1]);
    if (parameters.viewAxis != "auto") options.view = fit::viewMapping(parameters.viewAxis);
    if (parameters.roughnessAxis != "auto") options.roughness = fit::roughnessMapping(parameters.roughnessAxis);
}

Result<fit::SpecularTableOptions> optionsOf(const LutParameters& parameters) {
    fit::SpecularTableOptions options;
    options.lobe = parameters.lobe;
    options.normalization = normalizationOf(parameters.normalization).value();
    options.viewCount = parameters.viewCount;
    options.roughnessCount = parameters.roughnessCount;
    options.minimumM = parameters.minimumM;
    options.maximumM = parameters.maximumM;
    LC_CHECK(fit::checkSpecularTableOptions(options));
    chooseAxes(parameters, options);
    return options;
}

fit::SpecularTables integrate(const fit::SpecularTableOptions& options) {
    std::vector<std::vector<lighting::AreaSpecularKernel>> rows(static_cast<std::size_t>(options.roughnessCount));
    tbb::parallel_for(0, options.roughnessCount,
                      [&](int row) { rows[static_cast<std::size_t>(row)] = fit::integrateSpecularTableRow(options, row); });
    return fit::assembleSpecularTables(options, rows);
}

/// Returns the stored values of a texture in its format.
std::vector<std::byte> texelsOf(const fit::SpecularTexture& texture, formats::PixelFormat format, const TextureSettings& settings) {
    if (format == formats::PixelFormat::Rgba16Unorm) return bytesOf(texture.stored);
    formats::Image<glm::vec4> texels = texture.values.copy();
    for (glm::vec4& texel : texels.texels()) texel = glm::clamp((texel - texture.bias) / texture.scale, 0.0f, 1.0f);
    compress::EncodeReport report;
    return encodeImage(format, texels.view(), {}, settings.encodeOptions(), report);
}

}  // namespace

bool isLutFormat(formats::PixelFormat format) {
    return format == formats::PixelFormat::Rgba16Unorm || format == formats::PixelFormat::Rgba16f;
}

std::optional<lighting::CookTorranceNormalization> normalizationOf(const std::string& name) {
    if (name == "halo3") return lighting::CookTorranceNormalization::Halo3;
    return name == "energy" ? std::optional(lighting::CookTorranceNormalization::Energy) : std::nullopt;
}

Result<ActionOutcome> cookLut(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<LutParameters>(context));
    LC_TRY(options, optionsOf(*parameters));
    const fit::SpecularTables tables = integrate(*options);
    const std::array<const fit::SpecularTexture*, 3> parts = {&tables.c0236, &tables.d0236, &tables.cd78};

    LutConstants constants;
    constants.view = axisOf(tables.view, options->view);
    constants.roughness = axisOf(tables.roughness, options->roughness);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        constants.scale[i] = parts[i]->scale;
        constants.bias[i] = parts[i]->bias;
    }
    formats::TextureShape shape;
    const auto format = formats::pixelFormatFromName(parameters->format);
    if (!format || !isLutFormat(*format))
        return formats::failure(formats::ErrorCode::InvalidRequest, context.action.asset,
                                fmt::format("found the format \"{}\", expected rgba16-unorm or rgba16f", parameters->format));
    shape.format = *format;
    shape.width = options->viewCount;
    shape.height = options->roughnessCount;
    const std::string& name = context.action.asset;
    CookResult result{makeCookedAsset(name, AssetKind::Lut, "cook-torrance-cd", shape.width, shape.height), 0, {}};
    result.asset.distribution = formats::info(parameters->lobe).name;
    result.asset.normalization = parameters->normalization;
    result.asset.constants = toJson(constants);
    AssetTextures textures(context, parameters->textures,
                           {AssetKind::Lut, result.asset.layout, result.asset.distribution, result.asset.normalization});
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const std::string role = kLutRoles[i];
        LC_CHECK(textures.write({role, fmt::format("{}_{}", name, role), shape, *result.asset.constants},
                                {texelsOf(*parts[i], shape.format, parameters->textures)}));
    }
    return textures.finish(std::move(result));
}

}  // namespace lightcook::pipeline
