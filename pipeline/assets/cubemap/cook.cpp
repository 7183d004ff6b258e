#include "pipeline/assets/cubemap/cubemap.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "fit/cubemap.h"
#include "fit/pre_divide.h"
#include "formats/vocabulary.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/cubemap_layout.h"

namespace lightcook::pipeline {
namespace {

using formats::Image;
using formats::Result;

struct Levels {
    std::vector<Image<glm::vec3>> levels;  ///< each has six faces below each other
    std::vector<std::int64_t> clamped;     ///< for each level, values whose quotient is larger than any float
};

/// Prefilters every level, and divides it if there is a denominator. Rows are spread over the threads.
Levels filterLevels(const fit::CubemapPrefilter& filter, const std::optional<fit::PreDivide>& divide, const ActionContext& context) {
    struct Task {
        int mip, face, firstRow;
        formats::ImageView<glm::vec3> rows;
    };
    constexpr int kRowsPerTask = 8;
    std::vector<Image<glm::vec3>> levels;
    std::vector<Task> tasks;
    for (const fit::MipKernel& mip : filter.mips()) levels.emplace_back(mip.size, 6 * mip.size);
    for (int mip = 0; mip < filter.mipCount(); ++mip) {
        Image<glm::vec3>& level = levels[static_cast<std::size_t>(mip)];
        const int size = level.width();
        for (int face = 0; face < 6; ++face)
            for (int row = 0; row < size; row += kRowsPerTask)
                tasks.push_back({mip, face, row, level.view().rows(face * size + row, std::min(kRowsPerTask, size - row))});
    }
    const bool finished = forEachIndex(tasks.size(), context, "filter " + context.action.asset, [&](std::size_t index) {
        const Task& task = tasks[index];
        filter.filterRows(task.mip, task.face, task.firstRow, task.rows);
    });
    std::vector<std::atomic<std::int64_t>> clamped(levels.size());
    if (!finished) return {std::move(levels), {}};
    if (!divide) return {std::move(levels), std::vector<std::int64_t>(clamped.size())};
    tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t index) {
        const Task& task = tasks[index];
        clamped[static_cast<std::size_t>(task.mip)] += fit::preDivideRows(*divide, task.mip, task.face, task.firstRow, task.rows);
    });
    return {std::move(levels), {clamped.begin(), clamped.end()}};
}

/// Counts positive values that are too small for a half after division by the range: their product with S is black.
std::int64_t lostBelow(const Image<glm::vec3>& level, float range) {
    constexpr float kHalfOfSmallestHalf = 0x1p-25f;
    std::int64_t lost = 0;
    for (const glm::vec3& texel : level.texels())
        for (int channel = 0; channel < 3; ++channel) lost += texel[channel] > 0 && texel[channel] / range <= kHalfOfSmallestHalf ? 1 : 0;
    return lost;
}

/// Returns the strength of the window, and for each level that has any, the number of values whose stored * S differs from the prefiltered
/// value: the quotient was larger than any float (clamped) or smaller than any half (lost). Nothing of a map that is not divided.
Json divisionNotes(const std::optional<fit::PreDivide>& divide, const Levels& divided, float range) {
    if (!divide) return Json::object();
    Json notes = {{note_keys::kWindowLambda, divide->windowLambda},
                  {note_keys::kDivisionClamped, Json::object()},
                  {note_keys::kDivisionLost, Json::object()}};
    for (std::size_t mip = 0; mip < divided.levels.size(); ++mip) {
        const std::string level = fmt::format("level {}", mip);
        if (divided.clamped[mip] > 0) notes[note_keys::kDivisionClamped][level] = divided.clamped[mip];
        if (const std::int64_t lost = lostBelow(divided.levels[mip], range); lost > 0) notes[note_keys::kDivisionLost][level] = lost;
    }
    return notes;
}

float brightest(const std::vector<Image<glm::vec3>>& levels) {
    float largest = 0;
    for (const auto& level : levels)
        for (const glm::vec3& texel : level.texels()) largest = std::max({largest, texel.x, texel.y, texel.z});
    return largest;
}

CubemapConstants constantsOf(const fit::CubemapPrefilter& filter, const std::optional<fit::PreDivide>& divide, float range,
                             lighting::NormalDistribution lobe) {
    CubemapConstants constants;
    constants.kernel = lobe;
    constants.range = range;
    for (const fit::MipKernel& mip : filter.mips()) constants.mips.push_back({mip.perceptualRoughness, mip.m, mip.bands});
    if (!divide) return constants;
    constants.windowedSh = divide->windowedSh;
    constants.window = divide->window;
    constants.windowLambda = divide->windowLambda;
    constants.epsilon = divide->epsilon;
    return constants;
}

/// Returns kernel, size and roughness of the levels that are made. They are those of the whole chain, from the first level on.
fit::CubemapOptions levelsOf(const CubemapParameters& parameters) {
    fit::CubemapOptions options;
    options.kernel = parameters.lobe == lighting::NormalDistribution::Ggx ? fit::PrefilterKernel::Ggx : fit::PrefilterKernel::Beckmann;
    options.size = parameters.size >> parameters.firstLevel;
    const int last = lastCubemapLevel(parameters.size);
    for (int level = parameters.firstLevel; parameters.firstLevel > 0 && level <= last; ++level)
        options.roughness.push_back(std::pow(static_cast<double>(level) / last, 2));
    return options;
}

Result<CubemapLayoutInfo> layoutOf(const CubemapParameters& parameters, const std::string& asset) {
    if (const CubemapLayoutInfo* const layout = cubemapLayoutFromName(parameters.layout)) return *layout;
    return formats::failure(
        formats::ErrorCode::InvalidRequest, asset,
        fmt::format("found the layout \"{}\", expected {}", parameters.layout, formats::listOfNames(allCubemapLayouts())));
}

/// Returns the shape of the texture that holds some levels.
formats::TextureShape shapeOf(const std::vector<Image<glm::vec3>>& levels, formats::Target target) {
    formats::TextureShape shape;
    shape.format = formats::info(target).hdr;
    shape.width = shape.height = levels.front().width();
    shape.mipCount = static_cast<int>(levels.size());
    shape.faceCount = 6;
    return shape;
}

/// Returns the SH of a probe: stored beside it, or projected from its image.
Result<lighting::ShRgb> incidentSh(const formats::LoadedEnvironment& loaded, const CubemapParameters& parameters, const Action& action) {
    const auto stored = action.inputs.find("sh");
    if (stored == action.inputs.end()) return fit::projectEnvironment(loaded.environment);
    return formats::loadProbeSh(stored->second, parameters.probeFile.value_or(""));
}

/// Returns the denominator of a pre-divided cubemap, nothing for another layout.
Result<std::optional<fit::PreDivide>> denominatorOf(CubemapLayout layout, const fit::CubemapPrefilter& filter,
                                                    const formats::LoadedEnvironment& loaded, const CubemapParameters& parameters,
                                                    const Action& action) {
    if (layout != CubemapLayout::PreDivided) return std::nullopt;
    LC_TRY(sh, incidentSh(loaded, parameters, action));
    std::vector<lighting::ShBands> bands;
    for (const fit::MipKernel& mip : filter.mips()) bands.push_back(mip.bands);
    return fit::makePreDivide(*sh, bands, {});
}

/// Returns the place of a probe: of the parameters, else of the file of its SH.
Result<formats::ProbePlace> placeOf(const CubemapParameters& parameters, const Action& action) {
    formats::ProbePlace place = parameters.place;
    const auto stored = action.inputs.find("sh");
    if (stored == action.inputs.end()) return place;
    LC_TRY(given, formats::loadProbePlace(stored->second, parameters.probeFile.value_or("")));
    if (!place.position) place.position = given->position;
    if (!place.box) place.box = given->box;
    if (!place.radius) place.radius = given->radius;
    return place;
}

/// Returns the options for a level. A level of few texels costs little time at any effort, and a block that the fastest encoders miss is a
/// large part of its light.
compress::EncodeOptions encodeOptionsOf(const TextureSettings& settings, int levelSize) {
    constexpr int kFewTexels = 32, kLeastEffort = 5;
    compress::EncodeOptions options = settings.encodeOptions();
    if (levelSize <= kFewTexels) options.effort = std::max(options.effort, kLeastEffort);
    return options;
}

}  // namespace

Result<ActionOutcome> cookCubemap(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<CubemapParameters>(context));
    const auto& source = context.action.inputs.at("source");
    AssetSource read;
    read.colors = parameters->colors;
    read.repair = parameters->repair;
    LC_TRY(loaded, formats::loadEnvironment(source, environmentOptions(read, context.action)));
    LC_TRY(layout, layoutOf(*parameters, context.action.asset));
    const fit::CubemapOptions options = levelsOf(*parameters);
    LC_TRY(place, placeOf(*parameters, context.action));
    LC_TRY(filter, fit::CubemapPrefilter::create(loaded->environment, options));
    LC_TRY(divide, denominatorOf(layout->id, *filter, *loaded, *parameters, context.action));
    Levels filtered = filterLevels(*filter, *divide, context);
    if (context.state.interrupted) return interrupted(context);

    const float range = hdrRange(brightest(filtered.levels));
    const formats::TextureShape shape = shapeOf(filtered.levels, parameters->target);
    const Json divisions = divisionNotes(*divide, filtered, range);
    compress::EncodeReport report;
    std::vector<std::vector<std::byte>> images;
    for (Image<glm::vec3>& level : filtered.levels) {
        for (auto& face : encodeFaces(shape.format, level.view(), range, encodeOptionsOf(parameters->textures, level.width()), report))
            images.push_back(std::move(face));
        level = {};  // the largest level is 300 MB
    }
    CubemapConstants decode = constantsOf(*filter, *divide, range, parameters->lobe);
    decode.firstLevel = parameters->firstLevel;
    const Json constants = toJson(decode);
    const std::string& name = context.action.asset;
    AssetTextures textures(context, parameters->textures, {AssetKind::Cubemap, std::string(layout->name)});
    LC_CHECK(textures.write({"cubemap", name, shape, constants}, images));

    CookResult result{makeCookedAsset(name, AssetKind::Cubemap, std::string(layout->name), options.size, options.size),
                      std::filesystem::file_size(source),
                      Json{{note_keys::kRepairedTexels, loaded->repairedTexels}, {note_keys::kClampedHigh, report.clampedHigh}}};
    result.notes->update(divisions);
    result.asset.quantity = layout->quantity;
    result.asset.constants = constants;
    if (place->isKnown()) result.asset.probe = *place;
    result.asset.source = read;
    return textures.finish(std::move(result));
}

}  // namespace lightcook::pipeline
