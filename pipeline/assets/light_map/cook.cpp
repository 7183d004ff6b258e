#include <fmt/format.h>

#include "compress/light_map.h"
#include "compress/light_map_context.h"
#include "formats/chart_clusters.h"
#include "pipeline/assets/light_map/detail.h"
#include "pipeline/assets/light_map/kept_plan.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/mips.h"
#include "pipeline/assets/light_map/planner.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/dominant_layout.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// The index of a learned layout is a texture unless a mesh names the clusters.
bool hasIndexTexture(const compress::LightMapPlan& plan) {
    return plan.indexBytes() > 0 && plan.vertexBytes == 0;
}

/// Returns false for constants that are textures.
bool isInManifest(const compress::LightMapPlan& plan, const std::string& constant) {
    if (constant == kIndexRuns) return !hasIndexTexture(plan);
    return plan.tableBytes() == 0 || (constant != "code" && constant != "residual");
}

/// Returns the constants in the metadata of a texture: all but learned tables.
Json metadataConstants(const compress::LightMapPlan& plan) {
    Json constants = Json::object();
    for (const auto& [name, values] : plan.constants)
        if (values.size() <= kLargestMetadataConstant && isInManifest(plan, name)) constants[name] = values;
    return constants;
}

/// isDetailed  the map has detail
Result<AssetTextures> createTextures(const ActionContext& context, const compress::LightMapPlan& plan, const TextureSettings& settings,
                                     bool isDetailed) {
    AssetTextures textures(context, settings, {AssetKind::LightMap, std::string(formats::info(plan.layout).name)});
    for (const compress::LightMapTexture& texture : plan.textures) {
        const glm::ivec2 size = texture.sizeFor(plan.width, plan.height);
        formats::TextureShape shape;
        shape.format = texture.format;
        shape.width = size.x;
        shape.height = size.y;
        shape.mipCount = plan.mipCount;
        shape.layerCount = texture.layerCount;
        shape.isArray = texture.layerCount > 1;
        const char* const filter = plan.hasCoverage() ? "nearest" : plan.mipCount > 1 ? "trilinear" : "";
        LC_TRY(created, textures.create({texture.name, context.action.asset + "_" + texture.name, shape, metadataConstants(plan), filter,
                                         texture.side}));
    }
    if (!plan.hasCoverage()) return textures;
    const glm::ivec2 size = formats::coverageSize(plan.width, plan.height);
    formats::TextureShape shape;
    shape.format = formats::PixelFormat::Rgba8Unorm;
    shape.width = size.x;
    shape.height = size.y;
    shape.mipCount = plan.mipCount;
    shape.layerCount = isDetailed ? formats::kDetailedCoverageLayers : 1;
    shape.isArray = isDetailed;
    const std::string role(formats::kCoverageRole);
    LC_TRY(created, textures.create({role, fmt::format("{}_{}", context.action.asset, role), shape, metadataConstants(plan), "nearest"}));
    return textures;
}

/// Writes the index of a learned layout: a texel for each block of 4 x 4.
Result<void> writeIndex(const ActionContext& context, const compress::LightMapPlan& plan, AssetTextures& textures) {
    if (!hasIndexTexture(plan)) return {};
    formats::TextureShape shape;
    shape.format = formats::PixelFormat::Rgba8Unorm;
    shape.width = indexWidth(plan.width);
    shape.height = indexHeight(plan.height);
    return textures.write({kIndexRole, fmt::format("{}_{}", context.action.asset, kIndexRole), shape, metadataConstants(plan), "nearest"},
                          {plan.indexTexels()});
}

/// Writes the tables of a learned layout: a row for each cluster.
Result<void> writeTables(const ActionContext& context, const compress::LightMapPlan& plan, AssetTextures& textures) {
    if (plan.tableBytes() == 0) return {};
    formats::TextureShape shape;
    shape.format = formats::PixelFormat::Rgba16f;
    shape.width = plan.tableColumns();
    shape.height = static_cast<int>(plan.tableBytes()) / (plan.tableColumns() * formats::info(shape.format).bytesPerBlock);
    return textures.write({kTablesRole, fmt::format("{}_{}", context.action.asset, kTablesRole), shape, metadataConstants(plan), "nearest"},
                          {plan.tableTexels()});
}

/// Encodes a mip level.
/// source  the level
/// plan    of the level
Result<compress::EncodeReport> encodeStrips(LightMapSource& source, const compress::LightMapPlan& plan,
                                            const compress::EncodeOptions& options, AssetTextures& textures, int mip,
                                            const ActionContext& context) {
    using Report = compress::EncodeReport;
    const StripEncoder encoder(plan, options, context);
    const auto encodeStrip = [&](int index) -> Result<Report> {
        LC_TRY(strip, encoder.encode(source, index));
        const int firstRow = source.stripFirstRow(index);
        const compress::EncodedLightMapRows& rows = strip->rows;
        for (std::size_t texture = 0; texture < plan.textures.size(); ++texture) {
            const auto& [name, format, layerCount, side] = plan.textures[texture];
            const int firstBlockRow = firstRow / (side * formats::info(format).blockHeight);
            const auto& layers = rows.textures[texture].layers;
            for (std::size_t layer = 0; layer < layers.size(); ++layer)
                LC_CHECK(textures.writer(texture).writeBlockRows({mip, static_cast<int>(layer), 0}, firstBlockRow, layers[layer]));
        }
        if (plan.hasCoverage())
            LC_CHECK(textures.writer(plan.textures.size()).writeBlockRows({mip, 0, 0}, firstRow / formats::kCoverageRows, strip->coverage));
        return rows.report;
    };
    Report total;
    const auto encoded = foldInOrder<Report>(source.stripCount(), context, "encode " + context.action.asset, encodeStrip,
                                             [&](const Report& report) { total.add(report); });
    if (!encoded) return tl::make_unexpected(encoded.error());
    return total;
}

/// Encodes all levels.
Result<compress::EncodeReport> encodeLevels(LightMapSource& source, const compress::LightMapPlan& plan,
                                            const compress::EncodeOptions& options, AssetTextures& textures, const ActionContext& context) {
    auto report = encodeStrips(source, plan, options, textures, 0, context);
    for (int mip = 1; report && mip < plan.mipCount; ++mip) {
        LC_TRY(survey, source.mipSurvey(context));
        auto clusters = plan.clusterOfBlock().empty() ? std::vector<std::uint8_t>()
                                                      : clustersOfMip(**survey, mip, plan.width, plan.height, plan.clusterOfBlock());
        LC_TRY(encoded, encodeStrips(source.mip(mip), plan.ofMip(mip, std::move(clusters)), options, textures, mip, context));
        report->add(*encoded);
    }
    return report;
}

/// Plans the detail of a map; nothing where none was asked for, or no tile needs it.
Result<std::optional<DetailPlan>> detailOf(LightMapSource& source, const compress::LightMapPlan& plan, const LightMapParameters& parameters,
                                           const MapSurvey& survey, const ActionContext& context) {
    if (!parameters.detail) return std::optional<DetailPlan>();
    LC_TRY(detail, LightMapPlanner(source, parameters.target, parameters.textures, survey, {}, 1, context)
                       .plan(std::string(formats::info(formats::kDetailLayout).name), formats::LightMapFilter::Decoded, context));
    return planDetail(source, plan, std::move(*detail), *parameters.detail, survey, parameters.textures.encodeOptions(), context);
}

/// Plans a map.
Result<EncodingPlan> planMap(LightMapSource& source, const LightMapParameters& parameters, const MapSurvey& survey, int mipCount,
                             const ActionContext& context) {
    // The planner is a temporary: its samples are freed before the first strip is encoded.
    LC_TRY(plan, LightMapPlanner(source, parameters.target, parameters.textures, survey, parameters.visible, mipCount, context)
                     .plan(parameters.layout, parameters.filter, context));
    LC_TRY(detail, detailOf(source, *plan, parameters, survey, context));
    return EncodingPlan{std::move(*plan), std::move(*detail), survey.key.key(), survey.key.displayKey()};
}

/// Returns the plan of an earlier bake, if it is one for a map of this size and of these parameters.
Result<EncodingPlan> keptPlan(const LightMapSource& source, const LightMapParameters& parameters, const MapSurvey& survey, int mipCount,
                              const ActionContext& context) {
    const std::string& asset = context.action.asset;
    const KeptMap& kept = *parameters.kept;
    auto plan = context.parts == nullptr ? std::nullopt : EncodingPlan::find(*context.parts, kept.plan);
    if (!plan) return failure(ErrorCode::Verification, asset, "found no kept plan in the cache, expected that of its last cook");
    const compress::LightMapPlan& map = plan->map;
    const std::string_view layout = formats::info(map.layout).name;
    if (layout != parameters.layout || map.target != parameters.target ||
        map.filter != formats::info(map.layout).filterFor(parameters.filter) || (plan->detail && !parameters.detail))
        return failure(
            ErrorCode::Verification, asset,
            fmt::format("found a kept plan for {}, expected one for {} with its target, filter and detail", layout, parameters.layout));
    if (glm::ivec2(map.width, map.height) != glm::ivec2(source.width(), source.height()))
        return failure(ErrorCode::Verification, asset,
                       fmt::format("found {} x {} texels, expected {} x {} as in its kept plan", source.width(), source.height(), map.width,
                                   map.height));
    if (const int levels = map.hasCoverage() ? coverageLevels(map.width, map.height, mipCount) : mipCount; map.mipCount != levels)
        return failure(ErrorCode::Verification, asset,
                       fmt::format("found {} mip levels, expected {} as in its kept plan", levels, map.mipCount));
    if (!kept.serves(survey.key.key(), survey.key.displayKey()))
        return failure(
            ErrorCode::Verification, asset,
            fmt::format("found a key of {:.4g}, expected one within 1 % of that of its kept plan, {:.4g}", survey.key.key(), kept.key));
    return std::move(*plan);
}

/// Refuses a plan whose ranges clearly more values exceed than in the bake that it was made for.
Result<void> checkRanges(const EncodingPlan& plan, std::int64_t clamped, const std::string& asset) {
    const std::int64_t most = plan.clamped + plan.clamped / 100;  // quotients of texels that are almost black come and go
    if (clamped <= most) return {};
    return failure(ErrorCode::Verification, asset,
                   fmt::format("found {} values beyond the ranges of its kept plan, expected at most {}, 1 % more than in its own bake",
                               clamped, most));
}

CookedAsset manifestEntry(const std::string& name, const compress::LightMapPlan& plan, const LightMapParameters& parameters) {
    CookedAsset asset = makeCookedAsset(name, AssetKind::LightMap, std::string(formats::info(plan.layout).name), plan.width, plan.height);
    asset.bitsPerTexel = plan.bitsPerTexel();
    asset.decodeDegree = formats::info(plan.layout).decodeDegree;
    asset.filter = plan.filter;
    asset.constants = Json::object();
    for (const auto& [constant, values] : plan.constants)
        if (isInManifest(plan, constant)) (*asset.constants)[constant] = values;
    if (plan.tableBytes() > 0)
        (*asset.constants)[kTablesRole] = {{"file", fmt::format("{}_{}{}", name, kTablesRole, parameters.textures.extension())}};
    if (plan.vertexBytes > 0) asset.vertexBytes = plan.vertexBytes;
    if (parameters.isDominantDerived) asset.dominant = kDerivedDominant;
    asset.source.description = toJson(parameters.description);
    return asset;
}

/// Returns true if the texels are light as it is: engines whose formula has no range read HDR colours so.
bool storesLightUnscaled(const compress::LightMapPlan& plan) {
    return formats::info(plan.layout).textures.front().role == formats::TexelRole::Hdr && !plan.constants.contains("range");
}

Json notesOf(const MapSurvey& survey, const compress::LightMapPlan& plan, const compress::EncodeReport& report) {
    Json notes = {{note_keys::kCoveredTexels, survey.measure.coveredTexels()},
                  {note_keys::kBeyondPositiveBounds, survey.measure.beyondPositiveBounds()},
                  {note_keys::kRepairedNotFinite, survey.repairs.notFinite},
                  {note_keys::kRepairedNegativeDc, survey.repairs.negativeDc},
                  {note_keys::kRepairedBands, survey.repairs.bandsBeyond},
                  {note_keys::kRepairedFireflies, survey.repairs.fireflies},
                  {note_keys::kNegativeAfterGamut, survey.negativeAfterGamut},
                  {note_keys::kClampedHigh, report.clampedHigh},
                  {note_keys::kClampedNegative, report.clampedNegative}};
    if (report.clampedHigh > 0 && storesLightUnscaled(plan)) notes[note_keys::kClampedLight] = report.clampedHigh;
    return notes;
}

}  // namespace

Result<ActionOutcome> cookLightMap(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<LightMapParameters>(context));
    LC_TRY(source, openLightMap(context, parameters->description));
    const auto layout = formats::lightMapLayoutFromName(parameters->layout);
    // About as long as they take.
    const ActionContext measuring = context.between(0, 0.1), planning = context.between(0.1, 0.2), encoding = context.between(0.2, 1);
    LC_TRY(survey, (*source)->survey(measuring, layout && compress::needsSharedExit(*layout)));
    LC_TRY(mipCount, mipCountOf(**source, parameters->mips, measuring));
    LC_TRY(planned, parameters->kept ? keptPlan(**source, *parameters, **survey, *mipCount, planning)
                                     : planMap(**source, *parameters, **survey, *mipCount, planning));
    const compress::LightMapPlan& plan = planned->map;
    const std::optional<DetailPlan>& detail = planned->detail;
    LC_TRY(textures, createTextures(context, plan, parameters->textures, detail.has_value()));
    LC_TRY(report, encodeLevels(**source, plan, parameters->textures.encodeOptions(), *textures, encoding));
    LC_CHECK(writeIndex(context, plan, *textures));
    LC_CHECK(writeTables(context, plan, *textures));
    if (detail) {
        LC_CHECK(textures->writer(plan.textures.size()).writeBlockRows({0, 1, 0}, 0, detail->places()));
        LC_TRY(more, writeDetail(**source, *detail, parameters->textures, metadataConstants(detail->plan), *textures, context));
        report->add(*more);
    }
    CookedAsset asset = manifestEntry(context.action.asset, plan, *parameters);
    if (detail)
        asset.detail = CookedTiles{std::string(formats::info(formats::kDetailLayout).name), detail->tiles.size(), parameters->detail->limit,
                                   detail->plan.constants};
    if (detail) *asset.bitsPerTexel += 8.0 * static_cast<double>(detail->gpuBytes()) / (static_cast<double>(plan.width) * plan.height);
    asset.key = planned->displayKey;
    const std::int64_t clamped = report->clampedHigh + report->clampedNegative;
    if (parameters->kept) {
        LC_CHECK(checkRanges(*planned, clamped, context.action.asset));
        asset.plan = parameters->kept->plan;
    } else {
        planned->clamped = clamped;
        asset.plan = planned->digest();
        if (context.parts != nullptr) planned->store(*context.parts);
    }
    if (parameters->mips) {
        LC_TRY(mips, (*source)->mipSurvey(context));
        asset.mipsEnd = plan.mipCount < (*mips)->count ? coverageEnd(plan.width, plan.height, plan.mipCount) : (*mips)->end;
    }
    return textures->finish({std::move(asset), bakeBytes(context.action), notesOf(**survey, plan, *report)});
}

}  // namespace lightcook::pipeline
