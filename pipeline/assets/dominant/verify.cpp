#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/dominant/reduced_strip.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/dominant_fit.h"
#include "pipeline/scene/dominant_layout.h"
#include "shaders/lightcook_cpp.h"
#include "verify/block_errors.h"
#include "verify/dominant.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Image;
using formats::Result;

/// Decodes rows of a texture, from firstRow (a multiple of the block height) on: at least rowCount, as far as the map has them.
Result<Image<glm::vec4>> readRows(const formats::TextureReader& texture, int firstRow, int rowCount) {
    const formats::TextureShape& shape = texture.shape();
    const int blockHeight = formats::info(shape.format).blockHeight;
    const int blockRows = formats::blocksDown(shape.format, std::min(rowCount, shape.height - firstRow));
    Image<glm::vec4> rows(shape.width, std::min(blockRows * blockHeight, shape.height - firstRow));
    std::vector<std::byte> blocks(formats::bytesPerBlockRow(shape.format, shape.width) * static_cast<std::size_t>(blockRows));
    if (auto read = texture.readBlockRows({}, firstRow / blockHeight, blocks); !read) return tl::make_unexpected(read.error());
    verify::decodeRows(shape.format, blocks, rows.view());
    return rows;
}

/// Returns the exit radiance of a white Lambert surface under one dominant light.
glm::vec3 litBy(const glm::vec3& direction, const glm::vec3& intensity, const glm::vec3& normal) {
    const float cosine = std::max(glm::dot(normal, shaders::lcDominantDirection(direction, normal)), 0.0f);
    return cosine / std::numbers::pi_v<float> * intensity;
}

glm::dvec3 unitOf(const glm::dvec3& v) {
    return glm::length(v) > 0 ? glm::normalize(v) : v;
}

/// Squared errors of directions, without and with the residual texture. Lengths do not count, as the shader normalises, nor do texels whose
/// direction was turned for the filter, which neither texture has.
struct ResidualGain {
    double coarse = 0, fine = 0;
    void add(const glm::dvec3& truth, const glm::dvec3& first, const glm::dvec3& both) {
        const auto squared = [&](const glm::dvec3& seen) {
            const glm::dvec3 off = unitOf(seen) - unitOf(truth);
            return glm::dot(off, off);
        };
        constexpr double kTurned = 0.1;
        const double without = squared(first), with = squared(both);
        if (std::min(without, with) > kTurned * kTurned) return;
        coarse += without;
        fine += with;
    }
    void merge(const ResidualGain& other) {
        coarse += other.coarse;
        fine += other.fine;
    }
};

/// Adds the error of a light to its block. A light counts as three vectors, one a channel: intensity times direction.
void addLight(const verify::DominantLightSample& truth, const verify::DominantLightSample& seen, int x, int y,
              verify::BlockErrors& blocks) {
    double error = 0, reference = 0;
    for (int channel = 0; channel < 3; ++channel) {
        const glm::dvec3 difference = seen.intensity[channel] * unitOf(seen.direction) - truth.intensity[channel] * unitOf(truth.direction);
        error += glm::dot(difference, difference);
        reference += truth.intensity[channel] * truth.intensity[channel];
    }
    blocks.add(x, y, error, reference);
}

/// The textures of a cooked dominant light.
struct DominantTextures {
    formats::TextureReader direction, intensity;
    std::optional<formats::TextureReader> residual;
    int divisor = 1;  ///< of the light map's width and height
};

/// Returns the divisor that gives the textures their size, or what is wrong with it.
tl::expected<int, std::string> divisorOf(const DominantTextures& textures, const LightMapSource& bake) {
    const glm::ivec2 whole(bake.width(), bake.height());
    const auto sizeOf = [](const formats::TextureReader& texture) { return glm::ivec2(texture.shape().width, texture.shape().height); };
    const glm::ivec2 found = sizeOf(textures.direction);
    const bool areAlike = sizeOf(textures.intensity) == found && (!textures.residual || sizeOf(*textures.residual) == found);
    for (const DominantLayoutInfo& layout : allDominantLayouts())
        if (layout.divisor > 0 && areAlike && reducedSize(whole, layout.divisor) == found) return layout.divisor;
    return tl::make_unexpected(
        fmt::format("found textures of {} x {} texels, expected {} x {} as the source, or a half or a quarter of that", found.x, found.y,
                    whole.x, whole.y));
}

Result<DominantTextures> openTextures(const ActionContext& context, const CookedAsset& asset, const DominantConstants& constants,
                                      const LightMapSource& bake) {
    auto direction = openTexture(context.upstreamFolder, asset, "direction");
    if (!direction) return tl::make_unexpected(direction.error());
    auto intensity = openTexture(context.upstreamFolder, asset, "intensity");
    if (!intensity) return tl::make_unexpected(intensity.error());
    DominantTextures textures{std::move(*direction), std::move(*intensity), {}};
    if (constants.residualScale != 0) {
        auto residual = openTexture(context.upstreamFolder, asset, "residual");
        if (!residual) return tl::make_unexpected(residual.error());
        textures.residual = std::move(*residual);
    }
    const auto divisor = divisorOf(textures, bake);
    if (!divisor) return failure(ErrorCode::Verification, context.action.asset, divisor.error());
    textures.divisor = *divisor;
    return textures;
}

/// Some rows of the textures, decoded.
struct DecodedRows {
    verify::DecodedDominantRows rows;    ///< as the shader reads them, with the residual
    verify::DecodedDominantRows coarse;  ///< without the residual
};

/// Decodes every row that filters read at the rows [firstRow, firstRow + rowCount] of the light map.
Result<DecodedRows> decodeRows(const DominantTextures& textures, const DominantConstants& constants, const verify::CookedDominant& map,
                               int firstRow, int rowCount) {
    const verify::DominantRowRange needed = verify::dominantRowsFor(map, firstRow, firstRow + rowCount);
    const int blockHeight = formats::info(textures.direction.shape().format).blockHeight;
    const int first = needed.first / blockHeight * blockHeight, count = needed.first + needed.count - first;
    auto directions = readRows(textures.direction, first, count);
    if (!directions) return tl::make_unexpected(directions.error());
    auto intensities = readRows(textures.intensity, first, count);
    if (!intensities) return tl::make_unexpected(intensities.error());
    const auto copyOf = [](const Image<glm::vec4>& image) {
        Image<glm::vec4> copy(image.width(), image.height());
        std::ranges::copy(image.texels(), copy.texels().begin());
        return copy;
    };
    verify::DecodedDominantRows coarse{first, copyOf(*directions), copyOf(*intensities)};
    if (textures.residual) {
        const auto residual = readRows(*textures.residual, first, count);
        if (!residual) return tl::make_unexpected(residual.error());
        addResidual(*directions, *residual, constants);
    }
    return DecodedRows{{first, std::move(*directions), std::move(*intensities)}, std::move(coarse)};
}

/// Errors of some strips.
struct DominantPart {
    verify::DominantErrors errors;
    verify::BlockErrors blocks;
    ResidualGain gain;
    std::vector<verify::DominantTruthPlace> truthPlaces;
    void merge(const DominantPart& other) {
        errors.merge(other.errors);
        blocks.merge(other.blocks);
        gain.merge(other.gain);
        truthPlaces.insert(truthPlaces.end(), other.truthPlaces.begin(), other.truthPlaces.end());
    }
};

/// Compares a cooked dominant light with the bake, strip by strip.
class DominantComparison {
public:
    DominantComparison(LightMapSource& bake, const DominantTextures& textures, const DominantConstants& constants,
                       const verify::CookedDominant& map, const verify::DominantShading& shading, const GroundTruth& groundTruth,
                       double key, const verify::Viewing& viewing)
        : bake_(bake),
          textures_(textures),
          constants_(constants),
          map_(map),
          groundTruth_(groundTruth),
          key_(key),
          verifier_(map, shading, bake.luminanceWeights(), key, viewing),
          preview_(bake.width(), bake.height(), key),
          blockStep_(map.fit == verify::DominantFit::Closed ? 1 : 2) {}

    Result<DominantPart> compare(const ActionContext& context) {
        DominantPart whole{verify::DominantErrors(key_), verify::BlockErrors(bake_.width(), 0), {}, {}};
        const auto compared = foldInOrder<DominantPart>(
            bake_.stripCount(), context, "verify " + context.action.asset, [&](int index) { return compareStrip(index); },
            [&](const DominantPart& part) { whole.merge(part); });
        if (!compared) return tl::make_unexpected(compared.error());
        return whole;
    }
    const Preview& preview() const { return preview_; }

private:
    Result<DominantPart> compareStrip(int index) {
        const int firstRow = bake_.stripFirstRow(index), rowCount = bake_.stripRows(index);
        DominantPart part{verify::DominantErrors(key_), verify::BlockErrors(bake_.width(), rowCount, firstRow), {}, {}};
        const auto reference = bake_.stripWithMargin(index, 0, 1);
        if (!reference) return tl::make_unexpected(reference.error());
        const auto cooked = decodeRows(textures_, constants_, map_, firstRow, rowCount);
        if (!cooked) return tl::make_unexpected(cooked.error());
        for (int y = 0; y < rowCount; ++y)
            for (int x = 0; x < map_.width; ++x)
                if (isCompared(*reference, x, y, firstRow)) compareTexel(*reference, *cooked, x, y, firstRow, part);
        part.errors = verifier_.verifyRows(cooked->rows, *reference, firstRow, rowCount);
        const auto traced = groundTruth_.within(*reference, firstRow, rowCount);
        if (!traced) return tl::make_unexpected(traced.error());
        part.truthPlaces = dominantPlaces(*traced, *reference, verifier_, cooked->rows, map_.fit == verify::DominantFit::RefinedAmbient);
        return part;
    }

    /// A refined reference costs a search for each texel: four of the sixteen texels of a block are enough to find its faults.
    bool isCompared(const formats::LightMapStrip& reference, int x, int y, int firstRow) const {
        if (reference.covered.at(x, y) == 0) return false;
        return preview_.shows(x, firstRow + y) || (x % blockStep_ == 0 && y % blockStep_ == 0);
    }

    void compareTexel(const formats::LightMapStrip& reference, const DecodedRows& cooked, int x, int y, int firstRow, DominantPart& part) {
        const glm::vec3 normal = reference.normal.at(x, y);
        const auto seen = verifier_.decode(cooked.rows, x, firstRow + y);
        const auto truth = verifier_.reference(reference.sh.at(x, y), glm::dvec3(normal), seen);
        addLight(truth, seen, x, firstRow + y, part.blocks);
        part.gain.add(truth.direction, verifier_.decode(cooked.coarse, x, firstRow + y).direction, seen.direction);
        const glm::vec3 lit = litBy(glm::vec3(truth.direction), glm::vec3(truth.intensity), normal);
        const glm::vec3 litAsSeen = litBy(glm::vec3(seen.direction), glm::vec3(seen.intensity), normal);
        preview_.set(x, firstRow + y, lit, litAsSeen);
    }

    LightMapSource& bake_;
    const DominantTextures& textures_;
    const DominantConstants& constants_;
    const verify::CookedDominant& map_;
    const GroundTruth& groundTruth_;
    double key_;
    verify::DominantVerifier verifier_;
    Preview preview_;
    int blockStep_;  ///< of the texels that are compared for blocks
};

/// Returns the faults of a comparison: a block that is too far off, or a residual texture that makes directions worse.
std::vector<verify::Violation> violationsOf(const DominantPart& whole, bool hasResidual, double maxError, LightMapSource& bake) {
    std::vector<verify::Violation> violations;
    if (const auto block = checkBlocks(whole.blocks, "", maxError, violations))
        if (const auto texels = coveredOfBlock(bake, block->x, block->y); texels && !texels->empty()) {
            verify::ErrorPlace& at = violations.back().at;
            at.x = texels->front().x;
            at.y = texels->front().y;
            at.channel = -1;
            at.normal = glm::dvec3(texels->front().normal);
        }
    const ResidualGain& gain = whole.gain;
    // The second texture adds its own rounding, also to a first one that is exact.
    constexpr double kRounding = 1e-8;
    if (hasResidual && gain.fine > 1.05 * gain.coarse + kRounding)
        violations.push_back({"texture residual", fmt::format("a squared error of directions of {:.3g}", gain.fine),
                              fmt::format("no more than without it ({:.3g}): it belongs to something else", gain.coarse)});
    return violations;
}

}  // namespace

void addResidual(Image<glm::vec4>& directions, const Image<glm::vec4>& residual, const DominantConstants& constants) {
    for (std::size_t i = 0; i < residual.texels().size(); ++i)
        directions.texels()[i] = glm::vec4(shaders::lcDominantStored(glm::vec3(directions.texels()[i]), glm::vec3(residual.texels()[i]),
                                                                     constants.residualScale, constants.residualCentre),
                                           1.0f);
}

Result<ActionOutcome> verifyDominant(const ActionContext& context) {
    const Stopwatch watch;
    const auto asset = upstreamAsset(context);
    if (!asset) return tl::make_unexpected(asset.error());
    const auto maxError = maxErrorOf(context);
    if (!maxError) return tl::make_unexpected(maxError.error());
    const auto parameters = parametersOf<DominantVerifyParameters>(context);
    if (!parameters) return tl::make_unexpected(parameters.error());
    const auto constants = fromJson<DominantConstants>(asset->constants.value_or(Json()), asset->name + ", constants");
    if (!constants) return tl::make_unexpected(constants.error());
    const auto description = descriptionOf(*asset);
    if (!description) return tl::make_unexpected(description.error());
    const auto source = openLightMap(context, *description);
    if (!source) return tl::make_unexpected(source.error());
    LightMapSource& bake = **source;
    const auto textures = openTextures(context, *asset, *constants, bake);
    if (!textures) return tl::make_unexpected(textures.error());
    const auto surveyed = surveyKey(bake, context);
    if (!surveyed) return tl::make_unexpected(surveyed.error());
    const double key = surveyed->key();
    const auto groundTruth = GroundTruth::open(context, bake, description->colors);
    if (!groundTruth) return tl::make_unexpected(groundTruth.error());

    const auto fit = dominantFitOf(asset->name, asset->fit.value_or("halo3"));
    if (!fit) return tl::make_unexpected(fit.error());
    const verify::CookedDominant map{
        constants->directionScale, constants->directionBias, constants->intensityRange, bake.width(), bake.height(),
        (*fit)->verified,          textures->divisor};
    const verify::LightMapShading& materials = parameters->view.shading;
    const verify::DominantShading shading{materials.m, materials.f0, materials.viewCount, verify::dominantStride(map.width, map.height),
                                          materials.lobe};
    const verify::Viewing viewing{parameters->view.display.of(surveyed->displayKey()), bake.bt2020FromWorking()};
    DominantComparison comparison(bake, *textures, *constants, map, shading, *groundTruth, key, viewing);
    const auto whole = comparison.compare(context);
    if (!whole) return tl::make_unexpected(whole.error());

    const verify::DominantErrors& errors = whole->errors;
    VerifyResult result = judged(errors.stages(), *maxError, watch, violationsOf(*whole, textures->residual.has_value(), *maxError, bake),
                                 parameters->maxVisible);
    result.key = key;
    result.light.emplace().specularRms = errors.referenceRms();
    if (!whole->truthPlaces.empty()) result.groundTruth = toJson(verify::dominantTruth(whole->truthPlaces, materials.lobe, viewing));
    result.measures = {{"direction_error_degrees_mean", errors.meanDirectionError()},
                       {"direction_error_degrees_max", errors.maxDirectionError()},
                       {"unexplained_energy_stored", errors.unexplainedStored()},
                       {"unexplained_energy_reference", errors.unexplainedReference()},
                       {"shaded_every_texels", shading.stride}};
    return outcomeWithPreview(std::move(result), comparison.preview(), context);
}

}  // namespace lightcook::pipeline
