// Light at both sides of split edges, and the steps between them.
//
// A step is the difference (Delta E ITP) between both sides at one normal, or one normal, view and material. The added step is
// max(0, cooked - bake): it is at most the sum of the visible errors of both sides, because
//   |c_A - c_B| - |b_A - b_B| <= |(c_A - b_A) - (c_B - b_B)| <= |c_A - b_A| + |c_B - b_B|.
#include <algorithm>
#include <glm/vec2.hpp>
#include <tuple>
#include <utility>

#include "lighting/sphere.h"
#include "verify/light_map/covered_quad.h"
#include "verify/light_map/light_map_state.h"
#include "verify/seams.h"

namespace lightcook::verify {
namespace {

using lightmap::CoveredQuad;
using lightmap::MapDecoder;
using lightmap::MapRows;
using shaders::LcSh;

void store(const LcSh& sh, lighting::ShRgb& out) {
    std::copy_n(sh.c, lighting::kShCount, out.begin());
}

/// Returns the corner of a quad whose decode a surface at a place uses: the nearest one. Where vertices name the decode, it is that of the
/// chart, hence that of a covered corner.
int decodingCorner(const CoveredQuad& quad, const glm::vec2& at, bool isOfChart) {
    const int nearest = (at.x > 0.5f ? 1 : 0) + (at.y > 0.5f ? 2 : 0);
    if (!isOfChart || quad.covered[lightmap::index(nearest)]) return nearest;
    int best = nearest;
    float largest = -1;
    for (int corner = 0; corner < 4; ++corner) {
        const float weight = (corner % 2 == 1 ? at.x : 1 - at.x) * (corner / 2 == 1 ? at.y : 1 - at.y);
        if (!quad.covered[lightmap::index(corner)] || weight <= largest) continue;
        best = corner;
        largest = weight;
    }
    return best;
}

/// Stores the light of a place of a quad: that of the bake, then that of each stage.
bool storeLight(const MapRows& rows, const CoveredQuad& quad, const glm::vec2& at, bool isOfChart, std::span<lighting::ShRgb> light) {
    const auto [reference, covered] = quad.referenceAt(at);
    if (!(covered > 0)) return false;
    store(reference, light.front());
    const int corner = decodingCorner(quad, at, isOfChart);
    const MapDecoder& decoder = rows.decoder();
    std::array<LcSh, lightmap::kMostStages> stages;
    decoder.decodeStages(quad.texelsAt(at).data(), reference, rows.clusterOf(quad.x, quad.y, corner), stages);
    for (std::size_t stage = 0; stage < decoder.stages(); ++stage) store(stages[stage], light[1 + stage]);
    return true;
}

/// Light in all rows of a matrix, and as a display shows it.
struct ShownLight {
    std::vector<float> rgb, itp;  ///< [channel][row]
    explicit ShownLight(const ShadingMatrix& matrix) : rgb(3 * matrix.stride()), itp(rgb.size()) {}
};

/// Both sides of an edge, and the steps between them.
struct ShownSides {
    std::array<ShownLight, 2> sides;
    std::vector<float> steps;  ///< [row]
    explicit ShownSides(const ShadingMatrix& matrix) : sides{ShownLight(matrix), ShownLight(matrix)}, steps(matrix.stride()) {}
};

using Frame = std::array<glm::vec3, 3>;

/// Measures the steps of one kind of shading.
class StepMeter {
public:
    StepMeter(const ShadingMatrix& matrix, const DisplayTransform& display, double unit)
        : matrix_(matrix), display_(display), unit_(unit), bake_(matrix), cooked_(matrix), added_(matrix.stride()) {}
    bool isNone() const { return matrix_.count() == 0; }

    void setBake(const LitSeamPlace& place, const Frame& frame) { show(place, 0, frame, bake_); }
    double largestBakeStep() const { return static_cast<double>(bake_.steps[largestOf(bake_.steps)]); }
    /// Returns the largest step of the bake.
    SeamStep worstOfBake(const LitSeamPlace& place, const Frame& frame) const {
        return stepAt(place, frame, largestOf(bake_.steps), bake_);
    }

    /// light  index of the stage's light
    void addStage(const LitSeamPlace& place, std::size_t light, const Frame& frame, SeamErrors::Kind& errors) {
        show(place, light, frame, cooked_);
        for (std::size_t row = 0; row < added_.size(); ++row) added_[row] = std::max(0.0f, cooked_.steps[row] - bake_.steps[row]);
        errors.cooked.add({&cooked_.steps[largestOf(cooked_.steps)], 1});
        errors.added.add({&added_[largestOf(added_)], 1});
    }
    /// Returns the largest added step of the stage that was added last.
    SeamStep worstOfStage(const LitSeamPlace& place, const Frame& frame) const { return stepAt(place, frame, largestOf(added_), cooked_); }
    double largestAdded() const { return static_cast<double>(added_[largestOf(added_)]); }

private:
    std::size_t largestOf(const std::vector<float>& values) const {
        return static_cast<std::size_t>(std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(matrix_.count())) -
                                        values.begin());
    }
    void show(const LitSeamPlace& place, std::size_t light, const Frame& frame, ShownSides& out) const {
        for (std::size_t side = 0; side < 2; ++side) {
            LcSh sh;
            std::copy_n(place.light[side][light].begin(), lighting::kShCount, sh.c);
            const auto local = channelsOf(shaders::lcLocalSh(sh, frame[0], frame[1], frame[2]));
            ShownLight& shown = out.sides[side];
            for (std::size_t c = 0; c < local.size(); ++c) matrix_.apply(local[c], shown.rgb.data() + c * matrix_.stride());
            display_.apply(shown.rgb.data(), matrix_.stride(), shown.itp.data());
        }
        visibleDifferences(out.sides[0].itp.data(), out.sides[1].itp.data(), matrix_.stride(), out.steps.data());
    }
    std::array<glm::dvec3, 2> coloursOf(const ShownSides& shown, std::size_t row) const {
        std::array<glm::dvec3, 2> colours{};
        for (std::size_t side = 0; side < 2; ++side)
            for (std::size_t c = 0; c < 3; ++c)
                colours[side][static_cast<int>(c)] = unit_ * static_cast<double>(shown.sides[side].rgb[c * matrix_.stride() + row]);
        return colours;
    }
    SeamStep stepAt(const LitSeamPlace& place, const Frame& frame, std::size_t row, const ShownSides& cooked) const {
        const glm::dmat3 world(frame[0], frame[1], frame[2]);
        const ShadingSample& way = matrix_.sample(row);
        SeamStep step{.edge = place.edge, .along = place.along, .texel = place.texel};
        step.normal = world * way.normal;
        step.view = world * way.view;
        step.m = way.m;
        step.f0 = way.f0;
        step.bake = coloursOf(bake_, row);
        step.cooked = coloursOf(cooked, row);
        step.bakeStep = static_cast<double>(bake_.steps[row]);
        step.cookedStep = static_cast<double>(cooked.steps[row]);
        step.added = std::max(0.0, step.cookedStep - step.bakeStep);
        return step;
    }

    const ShadingMatrix& matrix_;
    const DisplayTransform& display_;
    double unit_;
    ShownSides bake_, cooked_;
    std::vector<float> added_;
};

/// Raises the list of worst edges, which has one entry for each.
void noteWorst(const SeamStep& step, std::vector<SeamStep>& worst) {
    if (worst.empty() || worst.back().edge != step.edge)
        worst.push_back(step);
    else if (step.added > worst.back().added)
        worst.back() = step;
}

/// Sorts a list of edges, keeps the larger entry of those that come twice, and drops all but the worst.
void keepWorst(std::vector<SeamStep>& worst) {
    const auto rank = [](const SeamStep& step) { return std::tuple(-step.added, step.edge, step.along); };
    std::ranges::sort(worst, [&](const SeamStep& a, const SeamStep& b) { return rank(a) < rank(b); });
    std::vector<SeamStep> kept;
    for (const SeamStep& step : worst)
        if (kept.size() < SeamErrors::kKept && std::ranges::find(kept, step.edge, &SeamStep::edge) == kept.end()) kept.push_back(step);
    worst = std::move(kept);
}

void takeLargerBake(SeamStep& largest, const SeamStep& other) {
    if (other.bakeStep > largest.bakeStep) largest = other;
}

Frame frameAt(const glm::vec3& normal) {
    const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(normal));
    return {glm::vec3(frame[0]), glm::vec3(frame[1]), glm::vec3(frame[2])};
}

}  // namespace

void SeamErrors::merge(const SeamErrors& other) {
    for (std::size_t i = 0; i < stages.size(); ++i)
        for (const auto kind : {&Stage::diffuse, &Stage::specular}) {
            (stages[i].*kind).added.merge((other.stages[i].*kind).added);
            (stages[i].*kind).cooked.merge((other.stages[i].*kind).cooked);
        }
    bakeDiffuse.merge(other.bakeDiffuse);
    bakeSpecular.merge(other.bakeSpecular);
    takeLargerBake(worstBakeDiffuse, other.worstBakeDiffuse);
    takeLargerBake(worstBakeSpecular, other.worstBakeSpecular);
    for (const auto list : {&SeamErrors::worstDiffuse, &SeamErrors::worstSpecular}) {
        (this->*list).insert((this->*list).end(), (other.*list).begin(), (other.*list).end());
        keepWorst(this->*list);
    }
}

std::size_t LightMapVerifier::lightCount() const {
    return 1 + layouts::infoOf(state_->layout).stages.size();
}

bool LightMapVerifier::lightAt(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference, const glm::dvec2& texel,
                               std::span<lighting::ShRgb> light) const {
    const glm::ivec2 corner(glm::floor(texel));
    const bool isOfChart = state_->map.clusterOfBlock.empty();
    const auto decoder = state_->decoderOn(reference);
    const MapRows rows(*decoder, state_->map, texels, reference);
    bool isLit = false;
    lightmap::withCoveredQuad(rows, corner.x, corner.y, [&](const CoveredQuad& quad) {
        isLit = storeLight(rows, quad, glm::vec2(texel - glm::dvec2(corner)), isOfChart, light);
    });
    return isLit;
}

SeamErrors LightMapVerifier::noSeamErrors() const {
    std::vector<SeamErrors::Stage> stages;
    for (const std::string_view name : layouts::infoOf(state_->layout).stages) stages.push_back({std::string(name), {}, {}});
    return SeamErrors(std::move(stages));
}

SeamErrors LightMapVerifier::seamErrors(std::span<const LitSeamPlace> places) const {
    SeamErrors errors = noSeamErrors();
    if (!state_->setup.matrices.visible) return errors;
    const VisibleShading& visible = *state_->setup.matrices.visible;
    const double unit = 1 / static_cast<double>(state_->perKey);
    StepMeter diffuse(visible.cap, visible.display, unit), specular(state_->setup.matrices.specular, visible.display, unit);
    const auto measure = [&](const LitSeamPlace& place, const Frame& frame, StepMeter& meter, SeamErrors::Kind SeamErrors::Stage::*kind,
                             VisibleAccumulator& bake, SeamStep& worstBake, std::vector<SeamStep>& worst) {
        if (meter.isNone()) return;
        meter.setBake(place, frame);
        const auto step = static_cast<float>(meter.largestBakeStep());
        bake.add({&step, 1});
        if (meter.largestBakeStep() > worstBake.bakeStep) worstBake = meter.worstOfBake(place, frame);
        for (std::size_t stage = 0; stage < errors.stages.size(); ++stage)
            meter.addStage(place, 1 + stage, frame, errors.stages[stage].*kind);
        if (worst.empty() || worst.back().edge != place.edge || meter.largestAdded() > worst.back().added)
            noteWorst(meter.worstOfStage(place, frame), worst);
    };
    for (const LitSeamPlace& place : places) {
        const Frame frame = frameAt(place.normal);
        measure(place, frame, diffuse, &SeamErrors::Stage::diffuse, errors.bakeDiffuse, errors.worstBakeDiffuse, errors.worstDiffuse);
        measure(place, frame, specular, &SeamErrors::Stage::specular, errors.bakeSpecular, errors.worstBakeSpecular, errors.worstSpecular);
    }
    keepWorst(errors.worstDiffuse);
    keepWorst(errors.worstSpecular);
    return errors;
}

}  // namespace lightcook::verify
