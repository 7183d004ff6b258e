// Encoding of rows under a learned layout: coefficient 0, then a code for each texel, then the residual layers. Each stage is solved
// against the decoded texels of those before it.
//
// Codes start from the left neighbour's: a texel that stays in the same local minimum gives smooth codes, which compress well. If that
// leaves a larger share of the light than it left at the neighbour (kMuchWorse), the cluster's seeds are searched, too, and the result is
// taken if it is clearly better (kClearlyBetter).
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "compress/light_map/basis/code_solver.h"
#include "compress/light_map/basis/sample.h"
#include "compress/light_map/families.h"

namespace lightcook::compress {

namespace {

using formats::Image;

constexpr float kMuchWorse = 1.1f, kClearlyBetter = 0.9f;

/// A strip on its way through the stages.
class BasisRows {
public:
    BasisRows(const LightMapPlan& plan, const formats::LightMapStrip& strip, const rows::Source& source, const EncodeOptions& options)
        : plan_(plan),
          model_(*plan.basis),
          strip_(strip),
          source_(source),
          options_(options),
          spaces_(model_.clusterCount()),
          ratio_(source.width, source.height),
          significance_(source.width, source.height, 0) {}

    EncodedLightMapRows run() {
        out_.textures.resize(plan_.textures.size());
        encodeL0();
        encodeCodes();
        for (std::size_t layer = 0; layer < model_.residual.size(); ++layer) encodeResidual(layer);
        return std::move(out_);
    }

private:
    void encodeL0() {
        const float range = rows::constant(plan_, "range", 0);
        rows::Layer l0 =
            rows::encodeHdr(plan_.textures[0].format, source_, 0, range, static_cast<float>(plan_.key), options_, true, out_.report);
        out_.textures[0].layers.push_back(std::move(l0.bytes));
        dc_ = std::move(l0.decoded);
        forEachCovered([&](int x, int y) {
            const glm::vec3 stored(dc_.at(x, y));
            ratio_.at(x, y) = ratiosTo(source_, x, y, range * stored);
            // An error of the code is multiplied by coefficient 0, here in units of the key and reduced where light is bright.
            const float unit = range / static_cast<float>(plan_.key + 1e-12), local = std::sqrt(source_.importance.at(x, y));
            const float visible = std::min(local * unit * glm::length(stored), 1e6f);
            significance_.at(x, y) = std::max(visible * visible, 1e-6f * source_.coverage.at(x, y));
        });
    }

    /// The decode of a cluster under the metric of a normal. One is kept for each cluster: a row crosses many charts and returns to each.
    struct CachedSpace {
        glm::vec3 normal{0};
        Metric metric;
        std::optional<CodeSpace> space;
    };
    CachedSpace& spaceAt(int x, int y) {
        const glm::ivec2 owner = source_.owner.at(x, y);
        const glm::vec3& normal = strip_.normal.at(owner.x, owner.y - strip_.firstRow);
        const std::size_t cluster = clusterAt(x, y);
        CachedSpace& cached = spaces_[cluster];
        if (!cached.space || cached.normal != normal) {
            cached.normal = normal;
            cached.metric = metrics_.at(normal);
            cached.space.emplace(model_.code[cluster], model_.shape, cached.metric, model_.seeds[cluster]);
        }
        return cached;
    }
    BasisTarget targetAt(int x, int y, const CachedSpace& cached) const {
        const glm::vec3 dc(dc_.at(x, y));
        return {ratio_.at(x, y), {dc.x * dc.x, dc.y * dc.y, dc.z * dc.z}, &cached.metric};
    }
    std::size_t clusterAt(int x, int y) const {
        const glm::ivec2 owner = source_.owner.at(x, y);
        return model_.clusterAt(owner.x, owner.y);
    }
    template <class Visit>
    void forEachCovered(Visit visit) const {
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x)
                if (source_.coverage.at(x, y) > 0) visit(x, y);
    }

    void encodeCodes() {
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(0.5f, 0.5f, 0.5f, 1));
        for (int y = 0; y < source_.height; ++y) {
            float leftShare = 0;  // error of the left neighbour's code over its light
            for (int x = 0; x < source_.width; ++x) {
                if (!(source_.coverage.at(x, y) > 0)) continue;
                const bool hasLeft = x > 0 && source_.coverage.at(x - 1, y) > 0 && clusterAt(x - 1, y) == clusterAt(x, y);
                CachedSpace& cached = spaceAt(x, y);
                const BasisTarget target = targetAt(x, y, cached);
                const float light = target.weight[0] + target.weight[1] + target.weight[2] + 1e-30f;
                std::optional<SolvedCode> solved;
                if (hasLeft) solved = cached.space->solve(target, texels.at(x - 1, y));
                if (!solved || solved->error > kMuchWorse * leftShare * light) {
                    const SolvedCode searched = cached.space->search(target);
                    if (!solved || searched.error < kClearlyBetter * solved->error) solved = searched;
                }
                texels.at(x, y) = solved->code;
                leftShare = solved->error / light;
            }
        }
        const Image<glm::vec4> decoded = encodeTexels(1, texels, model_.codeWeights, true);
        if (model_.residual.empty()) return;
        forEachCovered([&](int x, int y) {
            const CodeTable& table = model_.code[clusterAt(x, y)];
            subtractCode(evaluateCode(table, model_.shape.monomialCount(), decoded.at(x, y)), ratio_.at(x, y));
        });
    }

    void encodeResidual(std::size_t layer) {
        const bool isLast = layer + 1 == model_.residual.size();
        const std::vector<ResidualTable>& tables = model_.residual[layer];
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(kResidualNeutral));
        forEachCovered([&](int x, int y) { texels.at(x, y) = solveResidual(tables[clusterAt(x, y)], targetAt(x, y, spaceAt(x, y))); });
        const Image<glm::vec4> decoded = encodeTexels(2, texels, model_.residualWeights[layer], !isLast);
        if (isLast) return;
        forEachCovered([&](int x, int y) { subtractResidual(tables[clusterAt(x, y)], decoded.at(x, y), ratio_.at(x, y)); });
    }

    Image<glm::vec4> encodeTexels(std::size_t texture, Image<glm::vec4>& texels, const glm::vec4& weights, bool wantsDecoded) {
        EncodeOptions options = options_;
        for (int k = 0; k < 4; ++k) options.channelWeights[static_cast<std::size_t>(k)] = weights[k];
        rows::Layer layer = rows::encodeLayer(plan_.textures[texture].format, texels, significance_, options, wantsDecoded, out_.report);
        out_.textures[texture].layers.push_back(std::move(layer.bytes));
        return std::move(layer.decoded);
    }

    const LightMapPlan& plan_;
    const BasisModel& model_;
    const formats::LightMapStrip& strip_;
    const rows::Source& source_;
    const EncodeOptions& options_;
    EncodedLightMapRows out_;
    ShadingMetric metrics_;
    std::vector<CachedSpace> spaces_;  ///< [cluster]
    Image<glm::vec4> dc_;              ///< decoded coefficient 0 over range
    Image<ByChannel> ratio_;           ///< still to be coded, over the decoded coefficient 0
    Image<float> significance_;
};

}  // namespace

namespace rows {

EncodedLightMapRows encodeBasis(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source,
                                const EncodeOptions& options) {
    return BasisRows(plan, strip, source, options).run();
}

}  // namespace rows

}  // namespace lightcook::compress
