#include "pipeline/assets/light_map/planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "formats/gltf_scene.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/textures.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/scene.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Maps of more texels are tried on a part.
constexpr std::int64_t kTrialTexels = std::int64_t{1} << 20;

/// Every n-th strip, from the middle of the first n on.
std::vector<int> trialStrips(const LightMapSource& source) {
    const std::int64_t texels = static_cast<std::int64_t>(source.width()) * source.height();
    const int step = static_cast<int>(std::max<std::int64_t>(1, (texels + kTrialTexels - 1) / kTrialTexels));
    std::vector<int> strips;
    for (int strip = (step - 1) / 2; strip < source.stripCount(); strip += step) strips.push_back(strip);
    return strips;
}

/// A strip through the encoder and back through the verifier's own decoders.
verify::DecodedLightMapRows decodedRows(const compress::LightMapPlan& plan, const compress::EncodedLightMapRows& rows, int firstRow,
                                        int rowCount) {
    verify::DecodedLightMapRows out;
    out.firstRow = firstRow;
    for (std::size_t texture = 0; texture < plan.textures.size(); ++texture) {
        out.textures.emplace_back();
        for (const auto& bytes : rows.textures[texture].layers) {
            out.textures.back().emplace_back(plan.width, rowCount);
            verify::decodeRows(plan.textures[texture].format, bytes, out.textures.back().back().view());
        }
    }
    return out;
}

/// Errors at the texel centres of some strips under one plan.
Result<std::vector<verify::StageError>> tryPlan(LightMapSource& source, const compress::LightMapPlan& plan, const std::vector<int>& strips,
                                                const compress::EncodeOptions& options, const verify::LightMapShading& shading,
                                                const ActionContext& context) {
    const std::string layout(formats::info(plan.layout).name);
    verify::LightMapSampling sampling;
    sampling.positionsPerQuad = 0;
    sampling.bounds = false;
    const auto verifier = verify::LightMapVerifier::create({layout, plan.constants, plan.width, plan.height}, shading, sampling, plan.key);
    if (!verifier) return tl::make_unexpected(verifier.error());
    verify::LightMapErrors errors = verifier->noErrors();
    const auto verified = foldBands<verify::LightMapErrors>(
        static_cast<int>(strips.size()), context, fmt::format("try {} on {}", layout, context.action.asset),
        [&](int index) -> Result<verify::LightMapErrors> {
            const int strip = strips[static_cast<std::size_t>(index)], firstRow = source.stripFirstRow(strip),
                      rowCount = source.stripRows(strip);
            const auto band = source.stripWithMargin(strip, compress::kLightMapPaddingRows, compress::kLightMapPaddingRows);
            if (!band) return tl::make_unexpected(band.error());
            const auto rows = compress::encodeLightMapRows(plan, *band, firstRow, rowCount, options);
            return verifier->verifyRows(decodedRows(plan, rows, firstRow, rowCount), *band, firstRow, rowCount);
        },
        [&](const verify::LightMapErrors& part) { errors.merge(part); });
    if (!verified) return tl::make_unexpected(verified.error());
    return errors.stages();
}

/// A layout, the one whose trial tells its error, and by which of its stages. basis-4, -8 and -12 are basis-16 without the rest of its
/// residual, to the bit.
struct Trial {
    const char* layout;
    const char* tried;
    const char* stage;
};
constexpr std::array kTrials = {Trial{"raw", "raw", "total"},
                                Trial{"luvw", "luvw", "total"},
                                Trial{"luvw-linear", "luvw-linear", "total"},
                                Trial{"ratio", "ratio", "total"},
                                Trial{"zh3", "zh3", "total"},
                                Trial{"basis-3", "basis-3", "total"},
                                Trial{"basis-4", "basis-16", "code"},
                                Trial{"basis-8", "basis-16", "residual 1"},
                                Trial{"basis-12", "basis-16", "residual 2"},
                                Trial{"basis-16", "basis-16", "total"}};

/// What a plan would cost with as few residual layers as the shorter layout has.
struct Price {
    std::uint64_t bytes;
    double bitsPerTexel;
};
Price priceOf(const compress::LightMapPlan& plan, const std::string& layout) {
    const std::uint64_t bytes = plan.gpuBytesAs(*formats::lightMapLayoutFromName(layout));
    return {bytes, 8.0 * static_cast<double>(bytes) / (static_cast<double>(plan.width) * plan.height)};
}

const LightMapCandidate& smallestOf(const std::vector<LightMapCandidate>& candidates, double maxError) {
    const LightMapCandidate* best = &candidates.front();
    for (const LightMapCandidate& each : candidates) {
        const bool fits = each.error <= maxError, bestFits = best->error <= maxError;
        const bool isBetter = fits && bestFits ? each.bytes < best->bytes : fits != bestFits ? fits : each.error < best->error;
        if (isBetter) best = &each;
    }
    return *best;
}

/// Where the islands of the map's mesh lie, so that each vertex of it can name one basis. None without a mesh; nor of one that cannot be
/// read, which its own action tells of.
std::vector<formats::IslandRun> islandsOf(const Action& action, const LightMapSource& source) {
    const auto mesh = action.inputs.find(kMeshRole);
    if (mesh == action.inputs.end()) return {};
    const auto scene = formats::GltfScene::load(mesh->second);
    if (!scene) return {};
    return formats::islandRuns(scene->triangleMeshes(), source.width(), source.height());
}

}  // namespace

Result<MeasuredLightMap> measureLightMap(LightMapSource& source, const ActionContext& context) {
    auto parts = forEachBand<MeasuredLightMap>(
        source.bandCount(), context, "measure " + context.action.asset, [&](int index) -> Result<MeasuredLightMap> {
            const auto band = source.band(index);
            if (!band) return tl::make_unexpected(band.error());
            MeasuredLightMap part{compress::LightMapMeasure(source.luminanceWeights()), (*band)->repairs, (*band)->negativeAfterGamut};
            part.measure.add(**band);
            return part;
        });
    if (!parts) return tl::make_unexpected(parts.error());
    MeasuredLightMap whole{compress::LightMapMeasure(source.luminanceWeights()), {}, 0};
    for (const MeasuredLightMap& part : *parts) {
        whole.measure.merge(part.measure);
        whole.repairs += part.repairs;
        whole.negativeAfterGamut += part.negativeAfterGamut;
    }
    return whole;
}

LightMapPlanner::LightMapPlanner(LightMapSource& source, const Json& parameters, const compress::LightMapMeasure& measure,
                                 const ActionContext& context)
    : source_(source), measure_(measure), context_(context), target_(*formats::targetFromName(parameters.at("target").get<std::string>())) {
    options_ = TextureSettings::fromJson(parameters.at("textures")).encodeOptions();
}

Result<compress::LightMapPlan> LightMapPlanner::plan(const std::string& name) {
    const formats::LightMapLayout layout = *formats::lightMapLayoutFromName(name);
    if (!formats::info(layout).isLearned()) return compress::planLightMap(layout, target_, source_.width(), source_.height(), measure_);
    if (!samples_)
        if (auto gathered = gather(); !gathered) return tl::make_unexpected(gathered.error());
    compress::LightMapPlan plan = compress::planLearnedLightMap(layout, target_, source_.width(), source_.height(), measure_, blocks_,
                                                                charts_, *samples_, 0, options_);
    plan.isClusterInMesh = hasIslands_;
    return plan;
}

/// Charts from the coverage and the mesh, then the blocks worth looking at.
Result<void> LightMapPlanner::gather() {
    const auto walk = [&](const char* what, int count, auto&& visit) -> Result<void> {
        const auto walked = forEachBand<int>(count, context_, fmt::format("{} {}", what, context_.action.asset), visit);
        if (!walked) return tl::make_unexpected(walked.error());
        return {};
    };
    blocks_ = compress::LightMapBlocks(source_.width(), source_.height());
    const auto surveyed = walk("survey the charts of", source_.bandCount(), [&](int index) -> Result<int> {
        const auto band = source_.band(index);
        if (!band) return tl::make_unexpected(band.error());
        blocks_.add(**band, (*band)->firstRow, source_.bandRows(index));
        return 0;
    });
    if (!surveyed) return surveyed;
    const std::vector<formats::IslandRun> islands = islandsOf(context_.action, source_);
    charts_ = blocks_.charts(islands);
    hasIslands_ = !islands.empty();
    compress::LightMapSamples samples(blocks_.choose(charts_, compress::learningBlocks(options_.effort, source_.width(), source_.height())),
                                      blocks_.across());
    const auto sampled = walk("sample", source_.stripCount(), [&](int index) -> Result<int> {
        const auto band = source_.stripWithMargin(index, compress::LightMapSamples::kMargin, compress::LightMapSamples::kMargin);
        if (!band) return tl::make_unexpected(band.error());
        samples.add(*band, source_.stripFirstRow(index), source_.stripRows(index));
        return 0;
    });
    if (!sampled) return sampled;
    samples_ = std::move(samples);
    return {};
}

Result<ActionOutcome> tryLightMap(const ActionContext& context) {
    const Json& parameters = context.action.parameters;
    const auto source = openLightMap(context, parameters.at("description"));
    if (!source) return tl::make_unexpected(source.error());
    const auto measured = measureLightMap(**source, context);
    if (!measured) return tl::make_unexpected(measured.error());
    LightMapPlanner planner(**source, parameters, measured->measure, context);
    const std::vector<int> strips = trialStrips(**source);
    const compress::EncodeOptions options = TextureSettings::fromJson(parameters.at("textures")).encodeOptions();
    std::vector<Json> candidates;
    std::optional<compress::LightMapPlan> plan;
    std::vector<verify::StageError> stages;
    for (const Trial& trial : kTrials) {
        if (!plan || formats::info(plan->layout).name != trial.tried) {
            auto planned = planner.plan(trial.tried);
            if (!planned) return tl::make_unexpected(planned.error());
            plan = std::move(*planned);
            auto tried = tryPlan(**source, *plan, strips, options, shadingFromJson(parameters.at("shading")), context);
            if (!tried) return tl::make_unexpected(tried.error());
            stages = std::move(*tried);
        }
        const verify::StageError& error = *std::ranges::find(stages, trial.stage, &verify::StageError::name);
        const Price price = priceOf(*plan, trial.layout);
        candidates.push_back({{"layout", trial.layout},
                              {"bytes_gpu", price.bytes},
                              {"bits_per_texel", price.bitsPerTexel},
                              {"diffuse", error.diffuse.relRms},
                              {"specular", error.specular.relRms}});
    }
    std::ranges::stable_sort(candidates, {}, [](const Json& each) { return each.at("bytes_gpu").get<std::uint64_t>(); });
    ActionOutcome outcome;
    outcome.result["candidates"] = candidates;
    outcome.result["share"] = static_cast<double>(strips.size()) / (*source)->stripCount();
    return outcome;
}

std::vector<LightMapCandidate> candidatesOf(const ActionRecord& trial) {
    std::vector<LightMapCandidate> out;
    for (const Json& each : trial.result.at("candidates")) {
        // A figure that is not finite is written as null: such a layout serves nobody.
        const auto figure = [&](const char* name) {
            return each.at(name).is_number() ? each.at(name).get<double>() : std::numeric_limits<double>::infinity();
        };
        out.push_back({each.at("layout").get<std::string>(), each.at("bytes_gpu").get<std::uint64_t>(),
                       std::max(figure("diffuse"), figure("specular"))});
    }
    return out;
}

std::map<std::string, std::string> smallestWithin(const LightMapCandidates& candidates, double maxError) {
    std::map<std::string, std::string> layouts;
    for (const auto& [map, each] : candidates) layouts[map] = smallestOf(each, maxError).layout;
    return layouts;
}

std::map<std::string, std::string> bestWithin(const LightMapCandidates& candidates, std::uint64_t bytes) {
    std::set<double> bounds;
    for (const auto& [map, each] : candidates)
        for (const LightMapCandidate& candidate : each) bounds.insert(candidate.error);
    for (const double bound : bounds) {
        std::uint64_t used = 0;
        bool isHeld = true;
        for (const auto& [map, each] : candidates) {
            const LightMapCandidate& smallest = smallestOf(each, bound);
            used += smallest.bytes;
            isHeld = isHeld && smallest.error <= bound;
        }
        if (isHeld && used <= bytes) return smallestWithin(candidates, bound);
    }
    std::map<std::string, std::string> layouts;
    for (const auto& [map, each] : candidates) layouts[map] = std::ranges::min_element(each, {}, &LightMapCandidate::bytes)->layout;
    return layouts;
}

}  // namespace lightcook::pipeline
