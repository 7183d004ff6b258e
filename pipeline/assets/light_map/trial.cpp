#include "pipeline/assets/light_map/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <ranges>
#include <set>
#include <tuple>
#include <utility>

#include "compress/light_map.h"
#include "formats/light_map_layout.h"
#include "pipeline/assets/light_map/decoded_rows.h"
#include "pipeline/assets/light_map/detail.h"
#include "pipeline/assets/light_map/detailed_layout.h"
#include "pipeline/assets/light_map/joint_trial.h"
#include "pipeline/assets/light_map/layout_choice.h"
#include "pipeline/assets/light_map/mips.h"
#include "pipeline/assets/light_map/planner.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/light_map/trial_rows.h"
#include "pipeline/assets/light_map/whole_trial.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/dominant_layout.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Layouts that the scene's list lacks are measured on maps of at most this many texels.
constexpr std::int64_t kExcludedTexels = std::int64_t{1} << 18;

formats::LightMapLayout trialOf(const formats::LightMapLayoutInfo& layout) {
    return layout.trialLayout.value_or(layout.id);
}

/// A layout to measure.
struct Trial {
    const formats::LightMapLayoutInfo* layout;
    bool isExcluded;
};

/// Returns the layouts to measure, in the order of the table.
std::vector<Trial> trialsOf(const TrialParameters& parameters, std::int64_t texels) {
    std::vector<Trial> trials;
    std::set<formats::LightMapLayout> measured;
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts()) {
        const bool isUsual = layout.trialLayout || (layout.isFlat() && parameters.isFlatTried);
        const bool isTaken = parameters.layouts.empty() ? isUsual : formats::mayTake(parameters.layouts, layout);
        if (!parameters.decode.allow(layout) || !(isTaken || isUsual)) continue;
        if (parameters.description.constantOf && layout.isLearned()) continue;  // its mesh would name clusters of the bake
        trials.push_back({&layout, !isTaken});
        if (isTaken) measured.insert(trialOf(layout));
    }
    const auto isFlat = [](const Trial& each) { return each.layout->isFlat(); };
    const auto mayBeNeeded = [&](const Trial& each) {
        const formats::TexelRole first = each.layout->textures.front().role;
        const bool isListed = !parameters.layouts.empty() && !each.isExcluded;
        if (isFlat(each) || isListed) return true;
        if (!parameters.hasDirections) return each.layout->refinesCoefficient0();
        // A layout that stores directions which no shading shows is better than `flat` only if its first texture is finer.
        return parameters.shading.needsDirections() || first == formats::TexelRole::Half || first == formats::TexelRole::HdrFine;
    };
    if (std::ranges::any_of(trials, [&](const Trial& each) { return isFlat(each) && !each.isExcluded; }))
        std::erase_if(trials, std::not_fn(mayBeNeeded));
    if (texels > kExcludedTexels)
        std::erase_if(trials, [&](const Trial& each) { return each.isExcluded && !measured.contains(trialOf(*each.layout)); });
    return trials;
}

/// Layouts that are measured on one plan: the planned one, or it without its last layers.
struct LayoutGroup {
    const formats::LightMapLayoutInfo* planned;
    formats::LightMapFilter filter;
    std::vector<Trial> layouts;
};

/// Returns the least that a layout costs: fetches where they count, else 0, and the bits of a texel.
std::pair<int, int> leastCost(const formats::LightMapLayoutInfo& layout, const TrialParameters& parameters) {
    return {parameters.cost == formats::LayoutCost::Fetches ? parameters.decode.fetchesOf(layout) : 0,
            formats::textureBits(layout, formats::info(parameters.target))};
}

/// Returns the layouts to measure by the plan that they share, the cheapest first. Learned ones come together, the longest plan first.
std::vector<LayoutGroup> layoutGroups(const TrialParameters& parameters, std::int64_t texels) {
    std::vector<LayoutGroup> groups;
    for (const Trial& trial : trialsOf(parameters, texels)) {
        const formats::LightMapLayoutInfo& planned = formats::info(trialOf(*trial.layout));
        const formats::LightMapFilter filter = parameters.decode.filterOf(*trial.layout);
        if (groups.empty() || groups.back().planned != &planned || groups.back().filter != filter) groups.push_back({&planned, filter, {}});
        groups.back().layouts.push_back(trial);
    }
    const auto leastOf = [&](const LayoutGroup& group) {
        std::pair<int, int> least = leastCost(*group.layouts.front().layout, parameters);
        for (const Trial& each : group.layouts) least = std::min(least, leastCost(*each.layout, parameters));
        return least;
    };
    std::optional<std::pair<int, int>> learned;
    for (const LayoutGroup& group : groups)
        if (group.planned->isLearned()) learned = std::min(learned.value_or(leastOf(group)), leastOf(group));
    const auto rankOf = [&](const LayoutGroup& group) {
        return group.planned->isLearned() ? std::pair(*learned, -group.planned->layerCount()) : std::pair(leastOf(group), 0);
    };
    std::ranges::stable_sort(groups, [&](const LayoutGroup& a, const LayoutGroup& b) { return rankOf(a) < rankOf(b); });
    return groups;
}

/// Removes the layers that a shorter layout does not have.
void shorten(verify::DecodedLightMapRows& rows, const formats::LightMapLayoutInfo& layout) {
    rows.textures.resize(layout.textures.size());
    for (std::size_t i = 0; i < rows.textures.size(); ++i) rows.textures[i].resize(static_cast<std::size_t>(layout.textures[i].layerCount));
}

/// Shades the places of a joint trial under every layout of a group.
class GroupShader {
public:
    static Result<GroupShader> create(const LayoutGroup& group, const compress::LightMapPlan& plan, const verify::LightMapShading& shading,
                                      const WholeTrial* trial) {
        GroupShader shader(group, trial, plan.key);
        if (trial == nullptr) return shader;
        verify::LightMapSampling sampling;
        sampling.placesPerTexel = 0;
        sampling.figures = verify::LightMapFigures::Sampled;
        for (const Trial& each : group.layouts) {
            LC_TRY(verifier, verify::LightMapVerifier::create(cookedMapOf(plan, *each.layout), shading, sampling, plan.key));
            shader.verifiers_.push_back(std::move(*verifier));
        }
        return shader;
    }
    /// Returns true without a trial.
    bool isEmpty() const { return verifiers_.empty(); }
    /// Returns the samples of some rows by layout; nothing without a trial.
    std::vector<std::vector<float>> shade(verify::DecodedLightMapRows decoded, const formats::LightMapStrip& texels,
                                          const TrialRows& rows) const {
        std::vector<std::vector<float>> samples(verifiers_.size());
        for (std::size_t i = verifiers_.size(); i-- > 0;) {  // the longest last in the table
            shorten(decoded, *group_->layouts[i].layout);
            samples[i] = trial_->shadeLightMap(verifiers_[i], key_, decoded, texels, rows);
        }
        return samples;
    }

private:
    GroupShader(const LayoutGroup& group, const WholeTrial* trial, double key) : group_(&group), trial_(trial), key_(key) {}
    const LayoutGroup* group_;
    const WholeTrial* trial_;
    double key_;
    std::vector<verify::LightMapVerifier> verifiers_;
};

/// Returns the limits that a joint trial gives tiles detail for, and that of the map alone, ascending. None: no detail is tried.
std::vector<float> tileLimitsOf(const TrialParameters& parameters, bool isJoint) {
    std::vector<float> limits;
    if (!parameters.isDetailTried) return limits;
    if (isJoint) {
        constexpr int kCount = 16;  // from 1 to 13.6
        float limit = 1;
        for (int i = 0; i < kCount; ++i, limit *= 1.19f) limits.push_back(std::round(100 * limit) / 100);
    }
    if (parameters.detailLimit) limits.push_back(static_cast<float>(*parameters.detailLimit));
    std::ranges::sort(limits);
    limits.erase(std::unique(limits.begin(), limits.end()), limits.end());
    return limits;
}

/// The rows of a light map that layouts are measured on, and the display that their errors are judged on.
struct TriedMap {
    LightMapSource& source;
    const TrialParameters& parameters;
    verify::Viewing viewing;
    std::vector<float> tileLimits;  ///< tileLimitsOf()
};

/// Errors of some rows under a plan, by its layouts.
struct TriedRows {
    verify::LightMapErrors errors;
    std::vector<std::vector<float>> samples;  ///< [layout of the group] light of the places of a joint trial
};

/// Returns the errors of every stage of a plan on the surface of some rows of a map.
/// hasErrors  false: the samples of a joint trial alone
Result<TriedRows> tryPlan(const TriedMap& map, const compress::LightMapPlan& plan, const std::vector<TrialRows>& rows,
                          const GroupShader& shader, bool hasErrors, const ActionContext& context) {
    const std::string layout(formats::info(plan.layout).name);
    const compress::EncodeOptions options = map.parameters.textures.encodeOptions();
    verify::LightMapSampling sampling;
    sampling.figures = verify::LightMapFigures::Trial;
    sampling.tileLimits = map.tileLimits;
    LC_TRY(verifier, verify::LightMapVerifier::create(cookedMapOf(plan), map.parameters.shading, sampling, plan.key, map.viewing));
    TriedRows tried{verifier->noErrors(), {}};
    const auto verified = foldInOrder<TriedRows>(
        static_cast<int>(rows.size()), context, fmt::format("try {} on {}", layout, context.action.asset),
        [&](int index) -> Result<TriedRows> {
            const TrialRows& part = rows[static_cast<std::size_t>(index)];
            // Places below the last row are filtered from the next one too, and those of a joint trial from the one above.
            const int first = shader.isEmpty() ? part.firstRow : std::max(0, part.firstRow - plan.blockHeight()),
                      end = std::min(plan.height, part.firstRow + part.rowCount + plan.blockHeight());
            LC_TRY(planned, planRows(map.source, plan, options, first, end));
            TriedRows result{verifier->noErrors(), {}};
            if (hasErrors) result.errors = verifier->verifyRows(planned->decoded, planned->texels, part.firstRow, part.rowCount);
            result.samples = shader.shade(std::move(planned->decoded), planned->texels, part);
            return result;
        },
        [&](const TriedRows& part) {
            tried.errors.merge(part.errors);
            tried.samples.resize(part.samples.size());
            for (std::size_t i = 0; i < part.samples.size(); ++i)
                tried.samples[i].insert(tried.samples[i].end(), part.samples[i].begin(), part.samples[i].end());
        });
    if (!verified) return tl::make_unexpected(verified.error());
    return tried;
}

/// Returns the errors of a layout from the trial of a plan that it is a part of: basis-4 to -20 have the bits of basis-24 without the last
/// stages of its residual.
const verify::LightMapErrors::Stage& errorsOf(const formats::LightMapLayoutInfo& layout, const compress::LightMapPlan& plan,
                                              const verify::LightMapErrors& errors) {
    const auto stage = layout.id == plan.layout ? errors.stages.end()
                                                : std::ranges::find(errors.stages, layout.trialStage, &verify::LightMapErrors::Stage::name);
    return stage == errors.stages.end() ? errors.stages.back() : *stage;
}

/// Returns the objective of learned layouts in a trial. Empty: energy.
std::optional<SceneView> objectiveOf(const TrialParameters& parameters) {
    if (parameters.objective != formats::Objective::Visible) return std::nullopt;
    return SceneView{parameters.shading, parameters.display};
}

/// The passes of a trial and about how long they take beside each other, for its progress.
class TrialPasses {
public:
    TrialPasses(const std::vector<LayoutGroup>& groups, const std::optional<JointTrial>& joint) {
        constexpr double kMeasurement = 1, kReference = 0.7, kStored = 6, kLearned = 8, kOther = 2.5, kDetail = 8;
        add(kMeasurement);
        add(!joint ? 0 : joint->dominant && joint->dominant->layout == kStoredDominant ? kStored : kReference);
        for (const LayoutGroup& group : groups) add(group.planned->isLearned() ? kLearned : kOther);
        add(kDetail);
    }
    ActionContext measurement(const ActionContext& whole) const { return of(0, whole); }
    ActionContext reference(const ActionContext& whole) const { return of(1, whole); }
    ActionContext group(std::size_t index, const ActionContext& whole) const { return of(2 + index, whole); }
    /// Returns the pass that plans detail, when the groups have been measured.
    ActionContext detail(const ActionContext& whole) const { return of(ends_.size() - 2, whole); }

private:
    void add(double length) { ends_.push_back(ends_.back() + length); }
    ActionContext of(std::size_t pass, const ActionContext& whole) const {
        return whole.between(ends_[pass] / ends_.back(), ends_[pass + 1] / ends_.back());
    }
    std::vector<double> ends_ = {0};
};

/// Tries the layouts of a light map, in a joint trial beside its dominant light.
class LayoutTrial {
public:
    /// joint     empty for a trial of the light map alone
    /// groups    of layoutGroups()
    /// mipCount  levels of the map
    LayoutTrial(LightMapSource& source, const TrialParameters& parameters, const std::optional<JointTrial>& joint,
                std::vector<LayoutGroup> groups, const MapSurvey& survey, int mipCount, const ActionContext& context)
        : map_{source,
               parameters,
               {parameters.display.of(survey.key.displayKey()), source.bt2020FromWorking()},
               tileLimitsOf(parameters, joint.has_value())},
          joint_(joint),
          levels_(source),
          groups_(std::move(groups)),
          passes_(groups_, joint),
          planner_(source, parameters.target, parameters.textures, survey, objectiveOf(parameters), mipCount, context),
          context_(context) {}

    Result<JointTrialResult> run() {
        LC_CHECK(startJointTrial());
        for (const LayoutGroup& group : groups_) {
            if (!isNeeded(group)) continue;
            LC_CHECK(measure(group, firstLevel()));
            if (!measuresAll()) LC_CHECK(decide(group));
        }
        LC_CHECK(addDetail());
        if (best_) LC_CHECK(measureNextLarger());
        if (context_.state.interrupted) return interrupted(context_);
        return result();
    }

private:
    struct Tried {
        Trial trial;
        TrialCandidate candidate;
        verify::ShadedErrors errors;
        int level;                                 ///< of the rows that it was measured on
        verify::LightMapErrors::Stage first;       ///< of the first rows, with their tiles; none of a layout with detail
        std::optional<WholeCandidate> whole = {};  ///< of a joint trial
    };
    enum class Verdict { Keeps, Misses, Unsure };

    bool measuresAll() const { return map_.parameters.isComplete; }

    /// Returns the level that layouts are measured on first. rel_rms is that of the brightest texels: no sample knows it.
    int firstLevel() const {
        if (map_.parameters.isComplete || map_.parameters.limits[Limit::Error].value_or(kNoErrorLimit) < kNoErrorLimit)
            return levels_.last();
        return joint_ ? std::min(1, levels_.last()) : 0;
    }

    /// Shades the reference of a joint trial, and a dominant light that is stored.
    Result<void> startJointTrial() {
        if (!joint_) return {};
        const TrialParameters& parameters = map_.parameters;
        LC_TRY(trial, WholeTrial::create(map_.source, levels_.rows(0, firstLevel() + 1), levels_.rows(firstLevel() + 1, levels_.last() + 1),
                                         parameters.shading, map_.viewing));
        whole_.emplace(std::move(*trial));
        const std::optional<DominantTrial>& dominant = joint_->dominant;
        return whole_->start(dominant, {parameters.description, dominant ? dominant->fit : "", parameters.target, parameters.textures},
                             passes_.reference(context_));
    }

    auto costOf(const Tried& tried) const {
        return std::pair(map_.parameters.cost == formats::LayoutCost::Fetches ? tried.candidate.fetches : 0, tried.candidate.bytesGpu);
    }

    /// Returns true if a layout of the group may be cheaper than the best one so far.
    bool mayBeCheaper(const LayoutGroup& group) const {
        if (!best_) return true;
        return std::ranges::any_of(group.layouts, [&](const Trial& each) {
            const auto [fetches, bits] = leastCost(*each.layout, map_.parameters);
            const auto bytes = static_cast<std::uint64_t>(bits) * static_cast<std::uint64_t>(map_.source.width()) *
                               static_cast<std::uint64_t>(map_.source.height()) / 8;
            return std::pair(fetches, bytes) < costOf(tried_[*best_]);
        });
    }

    bool isNeeded(const LayoutGroup& group) const {
        if (measuresAll() || std::ranges::any_of(group.layouts, &Trial::isExcluded)) return true;
        const auto isFiner = [&](const Tried& each) {
            return each.trial.layout->isLearned() && each.trial.layout->codeCount > group.planned->codeCount &&
                   verdictOn(each) == Verdict::Misses;
        };
        return mayBeCheaper(group) && !(group.planned->isLearned() && std::ranges::any_of(tried_, isFiner));
    }

    ActionContext passOf(const LayoutGroup& group) const {
        return passes_.group(static_cast<std::size_t>(&group - groups_.data()), context_);
    }

    /// Measures the layouts of a group on levels [0, level].
    Result<void> measure(const LayoutGroup& group, int level) {
        const ActionContext pass = passOf(group);
        const double planned = group.planned->isLearned() ? 0.4 : 0;  // of the pass, about
        LC_TRY(plan, planner_.plan(std::string(group.planned->name), group.filter, pass.between(0, planned)));
        LC_TRY(shader, GroupShader::create(group, *plan, map_.parameters.shading, whole_ ? &*whole_ : nullptr));
        LC_TRY(measured, tryPlan(map_, *plan, levels_.rows(0, level + 1), *shader, true, pass.between(planned, 1)));
        for (std::size_t i = 0; i < group.layouts.size(); ++i) {
            const Trial& trial = group.layouts[i];
            const verify::LightMapErrors::Stage& stage = errorsOf(*trial.layout, *plan, measured->errors);
            tried_.push_back({trial, candidateOf(trial, *plan, stage.errors), stage.errors, level, stage});
            if (whole_ && !trial.isExcluded) addSamples(tried_.back(), measured->samples[i]);
        }
        return {};
    }

    /// Adds what places show under a layout in a joint trial.
    void addSamples(Tried& tried, const std::vector<float>& samples) {
        whole_->add(tried.candidate.layout, samples);
        tried.whole = whole_->candidateOf(tried.candidate.layout);
    }

    /// Measures a layout on further levels, up to `level`, in a pass of the trial.
    Result<void> measureMore(Tried& tried, int level, const ActionContext& pass) {
        const LayoutGroup alone{tried.trial.layout, map_.parameters.decode.filterOf(*tried.trial.layout), {tried.trial}};
        LC_TRY(plan, planner_.plan(std::string(tried.trial.layout->name), alone.filter, pass));
        LC_TRY(shader, GroupShader::create(alone, *plan, map_.parameters.shading, whole_ ? &*whole_ : nullptr));
        // A joint trial decides by its samples. The errors of the light map alone, which the report shows, stay those of the first levels.
        LC_TRY(more, tryPlan(map_, *plan, levels_.rows(tried.level + 1, level + 1), *shader, !whole_, pass));
        tried.level = level;
        if (whole_) {
            addSamples(tried, more->samples.front());
            return {};
        }
        tried.errors.merge(more->errors.stages.back().errors);
        tried.candidate = candidateOf(tried.trial, *plan, tried.errors);
        return {};
    }

    TrialCandidate candidateOf(const Trial& trial, const compress::LightMapPlan& plan, const verify::ShadedErrors& errors) const {
        const formats::LightMapLayoutInfo& layout = *trial.layout;
        const std::uint64_t bytes = plan.gpuBytesAs(layout.id);
        const verify::ErrorFigures diffuse = errors.diffuseFigures(), specular = errors.specularFigures();
        return {std::string(layout.name),
                bytes,
                8.0 * static_cast<double>(bytes) / (static_cast<double>(plan.width) * plan.height),
                diffuse.relRms,
                specular.relRms,
                diffuse.visible->p99,
                specular.visible ? specular.visible->p99 : 0,
                layout.fetchCount(plan.filter),
                layout.operations(plan.filter),
                plan.tableBytesAs(layout.id),
                trial.isExcluded};
    }

    /// Returns true if the layout was measured, and may have detail.
    bool mayHaveDetail(const Tried& tried) const {
        return !tried.trial.isExcluded && !tried.first.tiles.isEmpty() &&
               formats::mayHaveDetail(*tried.trial.layout, map_.parameters.decode, formats::info(map_.parameters.target));
    }
    /// Adds layouts with detail. A trial that ends at the best layout adds those that miss the limits, with as much as keeps them.
    Result<void> addDetail() {
        const std::vector<float>& limits = map_.tileLimits;
        if (limits.empty()) return {};
        const auto isWanted = [&](const Tried& each) {
            return mayHaveDetail(each) && (measuresAll() || verdictOn(each) != Verdict::Keeps);
        };
        if (std::ranges::none_of(tried_, isWanted)) return {};
        const auto isDetail = [](const Tried& each) { return each.trial.layout->id == formats::kDetailLayout && !each.trial.isExcluded; };
        for (const LayoutGroup& group : groups_)
            if (group.planned->id == formats::kDetailLayout && std::ranges::none_of(tried_, isDetail))
                LC_CHECK(measure(group, firstLevel()));
        const auto detail = std::ranges::find_if(tried_, isDetail);
        if (detail == tried_.end()) return {};
        LC_TRY(plan, planner_.plan(std::string(detail->trial.layout->name), formats::LightMapFilter::Decoded, passes_.detail(context_)));
        std::vector<Tried> added;
        for (const Tried& each : tried_)
            if (isWanted(each))
                for (std::size_t limit = 0; limit < limits.size(); ++limit)
                    if (auto detailed = withDetail(each, *detail, *plan, limit)) added.push_back(std::move(*detailed));
        keepBest(added);
        for (Tried& each : added) tried_.push_back(std::move(each));
        for (std::size_t i = 0; i < tried_.size() && !measuresAll(); ++i)
            if (!tried_[i].trial.isExcluded && verdictOn(tried_[i]) == Verdict::Keeps &&
                (!best_ || costOf(tried_[i]) < costOf(tried_[*best_])))
                best_ = i;
        return {};
    }
    /// Returns a layout with detail for a limit; nothing where none is needed or none helps.
    /// plan   of the detail
    /// limit  index of the limit among those of the tiles
    std::optional<Tried> withDetail(const Tried& map, const Tried& detail, const compress::LightMapPlan& plan, std::size_t limit) {
        const glm::ivec2 tiles = formats::coverageSize(plan.width, plan.height);
        const auto all = static_cast<std::size_t>(tiles.x) * static_cast<std::size_t>(tiles.y);
        const auto chosen = tilesWithin({map.first, detail.first, limit}, all);
        if (!chosen || chosen->empty()) return std::nullopt;
        const double share = levels_.share(firstLevel()), value = static_cast<double>(map.first.tiles.limits()[limit]);
        const auto count = static_cast<std::size_t>(std::ceil(static_cast<double>(chosen->size()) / share));
        if (count > static_cast<std::size_t>(formats::kMostDetailTiles)) return std::nullopt;
        Tried out{map.trial, map.candidate, map.errors, levels_.last(), {}};
        TrialCandidate& candidate = out.candidate;
        candidate.layout = DetailedLayout{map.candidate.layout, value}.name();
        candidate.bytesGpu += DetailPlan::gpuBytes(plan, count);
        if (best_ && candidate.bytesGpu >= tried_[*best_].candidate.bytesGpu && !measuresAll()) return std::nullopt;
        candidate.bitsPerTexel = 8.0 * static_cast<double>(candidate.bytesGpu) / (static_cast<double>(plan.width) * plan.height);
        candidate.visibleDiffuse = std::min(candidate.visibleDiffuse, value);
        candidate.visibleSpecular = std::min(candidate.visibleSpecular, value);
        std::tie(candidate.fetches, candidate.decodeOps) = formats::costWithDetail(*map.trial.layout);
        if (whole_) out.whole = whole_->candidateWith(candidate.layout, map.candidate.layout, detail.candidate.layout, *chosen);
        return out;
    }
    /// Keeps the layouts with detail that are the best of some size: no other with detail takes as little memory and errs as little, nor
    /// does one without that takes a little more. Detail takes time to find and fetches to read.
    void keepBest(std::vector<Tried>& detailed) const {
        constexpr double kWorth = 0.85;           // of the bytes without detail
        using Point = std::pair<double, double>;  // bytes and error
        const auto pointOf = [&](const Tried& each, double share) {
            return Point{share * static_cast<double>(each.candidate.bytesGpu), each.whole ? each.whole->visible : useOf(each)};
        };
        std::vector<Point> all;
        for (const Tried& each : tried_)
            if (!each.trial.isExcluded) all.push_back(pointOf(each, kWorth));
        for (const Tried& each : detailed) all.push_back(pointOf(each, 1));
        std::erase_if(detailed, [&](const Tried& each) {
            const Point point = pointOf(each, 1);
            return std::ranges::any_of(
                all, [&](const Point& other) { return other != point && other.first <= point.first && other.second <= point.second; });
        });
    }

    /// Returns the largest part of its limits that a layout uses.
    double useOf(const Tried& tried) const {
        const auto& ofWhole = map_.parameters.limits[Limit::WholeVisible];
        return tried.whole && ofWhole ? tried.whole->visible / *ofWhole : triedUse(tried.candidate, map_.parameters.limits);
    }

    /// Judges a layout by the rows that it was measured on. Of a trial of the light map alone, a sample within the limits is enough to take
    /// it: verification measures all rows, and refutes the layout where the sample was lucky (LayoutDecision). A joint trial is sure first:
    /// detail is tried for what misses the limits, and a refuted layout would make place for a larger one. Nothing corrects a layout that
    /// is refused wrongly, so that one a little above its limits is measured on more rows.
    Verdict verdictOn(const Tried& tried) const {
        const double used = useOf(tried), margin = levels_.margin(tried.level);
        if (used <= (tried.whole ? 1 / (1 + margin) : 1)) return Verdict::Keeps;
        return used > 1 + margin ? Verdict::Misses : Verdict::Unsure;
    }

    /// Finds the cheapest layout of the group that was just measured that keeps the limits, if it is cheaper than the best so far.
    Result<void> decide(const LayoutGroup& group) {
        std::vector<std::size_t> order;
        for (std::size_t i = tried_.size() - group.layouts.size(); i < tried_.size(); ++i)
            if (!tried_[i].trial.isExcluded) order.push_back(i);
        std::ranges::sort(order, {}, [&](std::size_t i) { return costOf(tried_[i]); });
        for (const std::size_t i : order) {
            if (best_ && costOf(tried_[i]) >= costOf(tried_[*best_])) break;
            while (verdictOn(tried_[i]) == Verdict::Unsure)
                LC_CHECK(measureMore(tried_[i], tried_[i].level + 1, passOf(group).between(1, 1)));
            if (verdictOn(tried_[i]) == Verdict::Keeps) best_ = i;
        }
        return {};
    }

    /// Measures layouts that cost more than the best one, up to the first of less error: the report says what that costs. Learned ones are
    /// left out, as they take long to plan.
    Result<void> measureNextLarger() {
        const auto isBetter = [&](const Tried& each) {
            return !each.trial.isExcluded && useOf(each) < useOf(tried_[*best_]) && costOf(each) > costOf(tried_[*best_]);
        };
        for (const LayoutGroup& group : groups_) {
            if (std::ranges::any_of(tried_, isBetter)) return {};
            const auto isOfGroup = [&](const Tried& each) { return each.trial.layout == group.layouts.front().layout; };
            if (!group.planned->isLearned() && std::ranges::none_of(tried_, isOfGroup)) LC_CHECK(measure(group, joint_ ? firstLevel() : 0));
        }
        return {};
    }

    JointTrialResult result() {
        JointTrialResult result;
        int level = levels_.last();
        std::size_t layouts = 0;
        for (const LayoutGroup& group : groups_) layouts += group.layouts.size();
        for (Tried& each : tried_) {
            result.trial.candidates.push_back(std::move(each.candidate));
            level = std::min(level, each.level);
        }
        for (const Tried& each : tried_)
            if (each.whole) result.whole.push_back(*each.whole);
        std::ranges::stable_sort(result.trial.candidates, {}, &TrialCandidate::bytesGpu);
        result.trial.share = levels_.share(level);
        result.trial.isPruned = best_ && tried_.size() < layouts;
        return result;
    }

    const TriedMap map_;
    const std::optional<JointTrial>& joint_;
    const TrialLevels levels_;
    const std::vector<LayoutGroup> groups_;
    const TrialPasses passes_;
    LightMapPlanner planner_;
    const ActionContext& context_;
    std::optional<WholeTrial> whole_;
    std::vector<Tried> tried_;
    std::optional<std::size_t> best_;  ///< the cheapest that keeps the limits, among tried_
};

/// Tries the layouts of a light map.
/// joint  empty for a trial of the light map alone
Result<JointTrialResult> tryLayouts(const TrialParameters& parameters, const std::optional<JointTrial>& joint,
                                    const ActionContext& context) {
    LC_TRY(source, openLightMap(context, parameters.description));
    std::vector<LayoutGroup> groups = layoutGroups(parameters, static_cast<std::int64_t>((*source)->width()) * (*source)->height());
    const bool hasSharedExit =
        std::ranges::any_of(groups, [](const LayoutGroup& group) { return compress::needsSharedExit(group.planned->id); });
    const ActionContext measurement = TrialPasses(groups, joint).measurement(context);
    LC_TRY(survey, (*source)->survey(measurement, hasSharedExit));
    LC_TRY(mipCount, mipCountOf(**source, parameters.mips, measurement));
    return LayoutTrial(**source, parameters, joint, std::move(groups), **survey, *mipCount, context).run();
}

}  // namespace

Result<ActionOutcome> tryLightMap(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<TrialParameters>(context));
    LC_TRY(result, tryLayouts(*parameters, std::nullopt, context));
    return outcomeWith(result->trial);
}

Result<ActionOutcome> tryJointly(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<JointTrialParameters>(context));
    LC_TRY(result, tryLayouts(parameters->trial, parameters->joint, context));
    return outcomeWith(*result);
}

Result<JointTrialResult> trialIn(const ActionRecord& record) {
    if (record.result.contains("whole")) return fromJson<JointTrialResult>(record.result, record.id);
    LC_TRY(trial, fromJson<TrialResult>(record.result, record.id));
    return JointTrialResult{std::move(*trial), {}};
}

}  // namespace lightcook::pipeline
