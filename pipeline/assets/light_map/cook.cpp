#include "pipeline/assets/light_map/light_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "compress/light_map.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/light_map/planner.h"
#include "pipeline/assets/lut/light_moments.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/textures.h"
#include "pipeline/assets/verdict.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "verify/sampler_tolerance.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::LightMapStrip;
using formats::Result;

formats::TextureShape shapeOf(const compress::LightMapPlan& plan, const compress::LightMapTexture& texture) {
    formats::TextureShape shape;
    shape.format = texture.format;
    shape.width = plan.width;
    shape.height = plan.height;
    shape.layerCount = texture.layerCount;
    shape.isArray = texture.layerCount > 1;
    return shape;
}

/// What a loader needs to decode a texture; but for learned tables.
Json factsOf(const compress::LightMapPlan& plan, const compress::LightMapTexture& texture) {
    Json facts = {{"layout", std::string(formats::info(plan.layout).name)}, {"role", texture.name}, {"constants", Json::object()}};
    // Learned tables are larger than some textures, and lie in the manifest alone.
    for (const auto& [name, values] : plan.constants)
        if (values.size() <= 16) facts["constants"][name] = values;
    return facts;
}

Result<compress::EncodeReport> encodeBands(LightMapSource& source, const compress::LightMapPlan& plan, const TextureSettings& settings,
                                           std::vector<formats::TextureWriter>& writers, const ActionContext& context) {
    const compress::EncodeOptions options = settings.encodeOptions();
    using Report = compress::EncodeReport;
    Report total;
    const auto encode = [&](int index) -> Result<Report> {
        const auto band = source.stripWithMargin(index, compress::kLightMapPaddingRows, compress::kLightMapPaddingRows);
        if (!band) return tl::make_unexpected(band.error());
        const int firstRow = source.stripFirstRow(index);
        const auto rows = compress::encodeLightMapRows(plan, *band, firstRow, source.stripRows(index), options);
        for (std::size_t texture = 0; texture < writers.size(); ++texture) {
            const int firstBlockRow = firstRow / formats::info(plan.textures[texture].format).blockHeight;
            for (std::size_t layer = 0; layer < rows.textures[texture].layers.size(); ++layer)
                if (auto written = writers[texture].writeBlockRows({0, static_cast<int>(layer), 0}, firstBlockRow,
                                                                   rows.textures[texture].layers[layer]);
                    !written)
                    return tl::make_unexpected(written.error());
        }
        return rows.report;
    };
    const auto encoded = foldBands<Report>(source.stripCount(), context, "encode " + context.action.asset, encode,
                                           [&](const Report& report) { total.add(report); });
    if (!encoded) return tl::make_unexpected(encoded.error());
    return total;
}

Json manifestEntry(const ActionContext& context, const compress::LightMapPlan& plan, const TextureSettings& settings) {
    const Json& parameters = context.action.parameters;
    Json asset = {{"name", context.action.asset},
                  {"kind", "light-map"},
                  {"layout", std::string(formats::info(plan.layout).name)},
                  {"width", plan.width},
                  {"height", plan.height},
                  {"bits_per_texel", plan.bitsPerTexel()},
                  {"quantity", "incident radiance"},
                  {"units", "radiometric"},
                  {"phase", "none"},
                  {"frame", "world"},
                  {"decode_degree", formats::info(plan.layout).decodeDegree},
                  {"constants", plan.constants},
                  {"textures", Json::array()},
                  {"source", {{"description", parameters.at("description")}}}};
    if (plan.tableBytes() > 0) {
        asset["bytes_gpu"] = plan.tableBytes();
        asset["bytes_disk"] = 0;  // in this manifest
    }
    for (const compress::LightMapTexture& texture : plan.textures) {
        const std::string file = context.action.asset + "_" + texture.name + std::string(settings.extension());
        asset["textures"].push_back(
            textureEntry(texture.name, file, shapeOf(plan, texture), std::filesystem::file_size(context.folder / file), {}));
    }
    return asset;
}

/// Stages of light-map layouts that code what the one before left.
constexpr std::pair<const char*, const char*> kResidualStages[] = {
    {"stage 1", "stage 2"}, {"code", "residual 1"}, {"residual 1", "residual 2"}, {"residual 2", "residual 3"}};

struct Squares {
    double error = 0, reference = 0;
    void add(const glm::vec3& truth, const glm::vec3& seen) {
        const glm::dvec3 difference = glm::dvec3(seen) - glm::dvec3(truth);
        error += glm::dot(difference, difference);
        reference += glm::dot(glm::dvec3(truth), glm::dvec3(truth));
    }
};

/// Of all nine coefficients; of a flat map, which has no others, of the exit radiance at the texel's own normal.
Squares squaresOf(const lighting::ShRgb& reference, const lighting::ShRgb& seen, const glm::vec3& normal, bool isFlat) {
    Squares squares;
    const auto exit = [&](const lighting::ShRgb& sh) { return lighting::lambertExitRadiance(sh, normal, glm::vec3(1)).value; };
    if (isFlat)
        squares.add(exit(reference), exit(seen));
    else
        for (std::size_t i = 0; i < reference.size(); ++i) squares.add(reference[i], seen[i]);
    return squares;
}

/// The texel, normal and channel of a block whose exit radiance is farthest off: its own normal, and 32 of the hemisphere about it.
Result<verify::ErrorPlace> worstInBlock(LightMapSource& bake, const CookedLightMapReader& cooked, const verify::BlockErrors::Block& block,
                                        double key) {
    const auto texels = coveredOfBlock(bake, block.x, block.y);
    if (!texels) return tl::make_unexpected(texels.error());
    constexpr int kRows = verify::BlockErrors::kSize, kNormals = 32;
    const int rowCount = std::min(kRows, bake.height() - block.y);
    const auto rows = cooked.read(block.y, rowCount);
    if (!rows) return tl::make_unexpected(rows.error());
    const auto seen = cooked.verifier().reconstruct(*rows, block.y, rowCount);
    verify::ErrorPlace worst;
    for (const BakedTexel& texel : *texels) {
        const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(texel.normal));
        for (int i = -1; i < kNormals; ++i) {
            const glm::dvec3 normal = i < 0 ? glm::dvec3(texel.normal) : frame * lighting::fibonacciHemisphere(i, kNormals);
            const auto exit = [&](const lighting::ShRgb& sh) {
                return glm::dvec3(lighting::lambertExitRadiance(sh, glm::vec3(normal), glm::vec3(1)).value);
            };
            const glm::dvec3 reference = exit(texel.sh), found = exit(seen.at(texel.x, texel.y - block.y));
            for (int channel = 0; channel < 3; ++channel) {
                const double local = std::abs(found[channel] - reference[channel]) /
                                     (std::abs(reference[channel]) + lighting::kLocalErrorFloor * (key > 0 ? key : 1));
                if (worst.isKnown() && !(local > worst.local)) continue;
                worst.x = texel.x;
                worst.y = texel.y;
                worst.channel = channel;
                worst.normal = normal;
                worst.reference = reference[channel];
                worst.found = found[channel];
                worst.local = local;
            }
        }
    }
    return worst;
}

/// RMS of the light that the map's errors are a part of. The verifier works in units of the key, where there is one.
Json lightOf(const verify::LightMapErrors& errors, double key, const LightMoments& light) {
    const double unit = key > 0 ? key : 1.0;
    const auto& centres = errors.accumulators.at(errors.accumulators.size() - 2);  // the last one is of places between texels
    return {{"diffuse_rms", unit * centres.diffuse.referenceRms()},
            {"specular_rms", unit * centres.specular.referenceRms()},
            {"moments", light.moments()},
            {"texels", light.texels()}};
}

}  // namespace

Result<ActionOutcome> cookLightMap(const ActionContext& context) {
    const Json& parameters = context.action.parameters;
    const TextureSettings settings = TextureSettings::fromJson(parameters.at("textures"));
    const auto source = openLightMap(context, parameters.at("description"));
    if (!source) return tl::make_unexpected(source.error());
    const auto measured = measureLightMap(**source, context);
    if (!measured) return tl::make_unexpected(measured.error());
    // The planner's sample goes before the first band is encoded.
    const auto planned = LightMapPlanner(**source, parameters, measured->measure, context).plan(parameters.at("layout").get<std::string>());
    if (!planned) return tl::make_unexpected(planned.error());
    const compress::LightMapPlan& plan = *planned;
    ActionOutcome outcome;
    std::vector<formats::TextureWriter> writers;
    for (const compress::LightMapTexture& texture : plan.textures) {
        const std::string file = context.action.asset + "_" + texture.name + std::string(settings.extension());
        auto writer = createTexture(context.folder / file, shapeOf(plan, texture), settings, textureMetadata(factsOf(plan, texture)));
        if (!writer) return tl::make_unexpected(writer.error());
        writers.push_back(std::move(*writer));
        outcome.files.push_back(file);
    }
    const auto report = encodeBands(**source, plan, settings, writers, context);
    if (!report) return tl::make_unexpected(report.error());
    for (formats::TextureWriter& writer : writers)
        if (auto committed = writer.commit(); !committed) return tl::make_unexpected(committed.error());

    outcome.result["asset"] = manifestEntry(context, plan, settings);
    outcome.result["bytes_in"] = std::filesystem::file_size(context.action.inputs.at("source"));
    outcome.result["notes"] = {
        {"covered_texels", measured->measure.coveredTexels()},  {"beyond_positive_bounds", measured->measure.beyondPositiveBounds()},
        {"repaired_not_finite", measured->repairs.notFinite},   {"repaired_negative_dc", measured->repairs.negativeDc},
        {"repaired_bands", measured->repairs.bandsBeyond},      {"repaired_fireflies", measured->repairs.fireflies},
        {"negative_after_gamut", measured->negativeAfterGamut}, {"clamped_high", report->clampedHigh},
        {"clamped_negative", report->clampedNegative}};
    return outcome;
}

Result<double> surveyKey(LightMapSource& bake, const ActionContext& context) {
    using verify::LightMapKey;
    const auto parts =
        forEachBand<LightMapKey>(bake.bandCount(), context, "survey " + context.action.asset, [&](int index) -> Result<LightMapKey> {
            const auto band = bake.band(index);
            if (!band) return tl::make_unexpected(band.error());
            LightMapKey part(bake.luminanceWeights());
            part.add(**band, (*band)->firstRow, bake.bandRows(index));
            return part;
        });
    if (!parts) return tl::make_unexpected(parts.error());
    LightMapKey key(bake.luminanceWeights());
    for (const LightMapKey& part : *parts) key.merge(part);
    return key.key();
}

Result<CookedLightMapReader> CookedLightMapReader::open(const std::filesystem::path& folder, const Json& asset,
                                                        const verify::LightMapShading& shading, const verify::LightMapSampling& sampling,
                                                        double key) {
    verify::CookedLightMap map;
    map.layout = asset.at("layout").get<std::string>();
    map.constants = asset.at("constants").get<std::map<std::string, std::vector<float>>>();
    map.width = asset.at("width").get<int>();
    map.height = asset.at("height").get<int>();
    const auto needs = verify::LightMapVerifier::texturesOf(map);
    if (!needs) return tl::make_unexpected(needs.error());
    std::vector<formats::TextureReader> textures;
    for (const auto& need : *needs) {
        auto texture = openTexture(folder, asset, need.name);
        if (!texture) return tl::make_unexpected(texture.error());
        const formats::TextureShape& shape = texture->shape();
        if (shape.layerCount != need.layerCount || shape.width != map.width || shape.height != map.height)
            return failure(ErrorCode::Verification, asset.at("name").get<std::string>() + ", texture " + need.name,
                           fmt::format("found {} x {} with {} layers, expected {} x {} with {}", shape.width, shape.height,
                                       shape.layerCount, map.width, map.height, need.layerCount));
        map.formats.push_back(shape.format);
        textures.push_back(std::move(*texture));
    }
    auto verifier = verify::LightMapVerifier::create(map, shading, sampling, key);
    if (!verifier) return tl::make_unexpected(verifier.error());
    CookedLightMapReader reader(std::move(*verifier), map.width, map.height);
    reader.textures_ = std::move(textures);
    return reader;
}

Result<verify::DecodedLightMapRows> CookedLightMapReader::read(int firstRow, int rowCount) const {
    verify::DecodedLightMapRows rows;
    rows.firstRow = firstRow;
    for (const formats::TextureReader& texture : textures_) {
        const formats::PixelFormat format = texture.shape().format;
        const int blockHeight = formats::info(format).blockHeight;
        const int blockRows = formats::blocksDown(format, std::min(rowCount, height_ - firstRow));
        const int texelRows = std::min(blockRows * blockHeight, height_ - firstRow);
        std::vector<std::byte> blocks(formats::bytesPerBlockRow(format, width_) * static_cast<std::size_t>(blockRows));
        std::vector<formats::Image<glm::vec4>> layers, spans;
        for (int layer = 0; layer < texture.shape().layerCount; ++layer) {
            if (auto read = texture.readBlockRows({0, layer, 0}, firstRow / blockHeight, blocks); !read)
                return tl::make_unexpected(read.error());
            layers.emplace_back(width_, texelRows);
            verify::decodeRows(format, blocks, layers.back().view());
            spans.push_back(verify::blockSpans(format, blocks, width_));
        }
        rows.textures.push_back(std::move(layers));
        rows.spans.push_back(std::move(spans));
    }
    return rows;
}

Result<ActionOutcome> verifyLightMap(const ActionContext& context) {
    const Stopwatch watch;
    const Json& parameters = context.action.parameters;
    const Json& asset = context.upstream.at(0)->result.at("asset");
    const auto source = openLightMap(context, asset.at("source").at("description"));
    if (!source) return tl::make_unexpected(source.error());
    LightMapSource& bake = **source;
    if (bake.width() != asset.at("width").get<int>() || bake.height() != asset.at("height").get<int>())
        return failure(ErrorCode::Verification, context.action.inputs.at("source").string(),
                       fmt::format("found {} x {} texels, expected {} x {} as cooked", bake.width(), bake.height(),
                                   asset.at("width").get<int>(), asset.at("height").get<int>()));

    const auto key = surveyKey(bake, context);
    if (!key) return tl::make_unexpected(key.error());
    verify::LightMapSampling sampling;
    sampling.positionsPerQuad = parameters.at("samples").get<int>();
    const auto cooked =
        CookedLightMapReader::open(context.upstreamFolder, asset, shadingFromJson(parameters.at("shading")), sampling, *key);
    if (!cooked) return tl::make_unexpected(cooked.error());
    const auto truth = GroundTruth::open(context, bake, asset.at("source").at("description"));
    if (!truth) return tl::make_unexpected(truth.error());
    Preview preview(bake.width(), bake.height(), *key);
    verify::BlockErrors blocks(bake.width(), 0);
    std::vector<verify::LightMapTruthPlace> truthPlaces;
    const bool isFlat = asset.at("layout") == "flat";
    using verify::LightMapErrors;
    LightMapErrors errors = cooked->verifier().noErrors();
    struct Part {
        LightMapErrors errors;
        verify::BlockErrors blocks;
        std::vector<verify::LightMapTruthPlace> truthPlaces;
        LightMoments light;
    };
    LightMoments light;
    const auto verified = foldBands<Part>(
        bake.stripCount(), context, "verify " + context.action.asset,
        [&](int index) -> Result<Part> {
            const int firstRow = bake.stripFirstRow(index), rowCount = bake.stripRows(index);
            verify::BlockErrors partBlocks(bake.width(), rowCount, firstRow);
            const auto reference = bake.stripWithMargin(index, 0, 1);
            if (!reference) return tl::make_unexpected(reference.error());
            const auto texels = cooked->read(firstRow, rowCount + 1);
            if (!texels) return tl::make_unexpected(texels.error());
            const auto seen = cooked->verifier().reconstruct(*texels, firstRow, rowCount);
            LightMoments partLight;
            for (int y = 0; y < rowCount; ++y)
                for (int x = 0; x < bake.width(); ++x) {
                    if (reference->covered.at(x, y) == 0) continue;
                    const glm::vec3 normal = reference->normal.at(x, y);
                    partLight.add(reference->sh.at(x, y), normal);
                    const Squares squares = squaresOf(reference->sh.at(x, y), seen.at(x, y), normal, isFlat);
                    partBlocks.add(x, firstRow + y, squares.error, squares.reference);
                    const glm::vec3 lit = lighting::lambertExitRadiance(reference->sh.at(x, y), normal, glm::vec3(1)).value;
                    const glm::vec3 found = lighting::lambertExitRadiance(seen.at(x, y), normal, glm::vec3(1)).value;
                    preview.set(x, firstRow + y, lit, found);
                }
            const auto traced = truth->within(*reference, firstRow, rowCount);
            if (!traced) return tl::make_unexpected(traced.error());
            return Part{cooked->verifier().verifyRows(*texels, *reference, firstRow, rowCount), std::move(partBlocks),
                        lightMapPlaces(*traced, *reference, seen, firstRow), partLight};
        },
        [&](const Part& part) {
            errors.merge(part.errors);
            blocks.merge(part.blocks);
            light.merge(part.light);
            truthPlaces.insert(truthPlaces.end(), part.truthPlaces.begin(), part.truthPlaces.end());
        });
    if (!verified) return tl::make_unexpected(verified.error());

    const std::vector<verify::StageError> stages = errors.stages();
    std::vector<verify::Violation> violations;
    if (const auto block = checkBlocks(blocks, "", maxErrorOf(context), violations)) {
        const auto worst = worstInBlock(bake, *cooked, *block, *key);
        if (!worst) return tl::make_unexpected(worst.error());
        violations.back().at = *worst;
    }
    for (const auto& [before, after] : kResidualStages) checkStage(stages, before, after, violations);
    ActionOutcome outcome = outcomeOf(stages, context, watch, violations);
    outcome.result["key"] = *key;
    outcome.result["light"] = lightOf(errors, *key, light);
    if (!truth->isEmpty()) outcome.result["ground_truth"] = toJson(verify::lightMapTruth(truthPlaces));
    if (auto written = preview.write(context.folder, context.action.asset, outcome); !written) return tl::make_unexpected(written.error());
    return outcome;
}

Json toJson(const verify::LightMapShading& shading) {
    return {{"specular", shading.specular},
            {"m", shading.m},
            {"f0", shading.f0},
            {"views", shading.viewCount},
            {"normals", shading.normalCount}};
}

verify::LightMapShading shadingFromJson(const Json& json) {
    verify::LightMapShading shading;
    shading.specular = json.at("specular").get<bool>();
    shading.m = json.at("m").get<std::vector<double>>();
    shading.f0 = json.at("f0").get<std::vector<double>>();
    shading.viewCount = json.at("views").get<int>();
    shading.normalCount = json.at("normals").get<int>();
    return shading;
}

}  // namespace lightcook::pipeline
