// Encoding of rows under a learned layout: a code for each texel, then coefficient 0, then the residual layers. Each stage is solved
// against the decoded texels of those before it. Coefficient 0 comes after the codes, since its three numbers can compensate for much of
// their error; codes are solved in turns with it.
//
// A row of blocks goes through all stages before the next, so that the forms of its texels (shading_form.h), which cost more to compute
// than a code, are computed once for all stages.
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

/// Inputs and settings that the rows of a strip share.
struct BasisContext {
    const LightMapPlan& plan;
    const BasisModel& model;
    const formats::LightMapStrip& strip;
    const EncodeOptions& options;
    float range;  ///< of coefficient 0: all light below is over it
    ShadingForm shading;
    std::vector<CodeSpace> spaces;  ///< [cluster]

    BasisContext(const LightMapPlan& planOfMap, const formats::LightMapStrip& rowsOfMap, const EncodeOptions& encodeOptions)
        : plan(planOfMap),
          model(*planOfMap.basis),
          strip(rowsOfMap),
          options(encodeOptions),
          range(rows::constant(plan, "range", 0)),
          shading(plan.objective, static_cast<double>(range), model.lightSquare) {
        for (std::size_t cluster = 0; cluster < model.clusterCount(); ++cluster)
            spaces.emplace_back(model.code[cluster], model.shape, model.seeds[cluster]);
    }
};

/// Some rows of blocks on their way through the stages.
class BasisRows {
public:
    BasisRows(BasisContext& context, const rows::Source& source)
        : plan_(context.plan),
          model_(context.model),
          strip_(context.strip),
          source_(source),
          options_(context.options),
          range_(context.range),
          shading_(context.shading),
          spaces_(context.spaces),
          forms_(static_cast<std::size_t>(source.width) * static_cast<std::size_t>(source.height)),
          ratio_(source.width, source.height),
          significance_(source.width, source.height, 0) {}

    EncodedLightMapRows run() {
        out_.textures.resize(plan_.textures.size());
        rows::forEachPadded(source_, [&](int x, int y) {
            const glm::ivec2 owner = source_.owner.at(x, y);
            forms_[indexOf(x, y)] = shading_.at(source_.lightAt(x, y, range_), strip_.normal.at(owner.x, owner.y - strip_.firstRow));
        });
        encodeCodes();
        encodeL0();
        for (std::size_t layer = 0; layer < model_.residual.size(); ++layer) encodeResidual(layer);
        return std::move(out_);
    }

private:
    std::size_t indexOf(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(source_.width) + static_cast<std::size_t>(x);
    }
    ErrorForm formAt(int x, int y) const { return forms_[indexOf(x, y)].unpacked(); }
    /// Sets the weight of a texel's numbers: their sensitivity over the weights of the channels.
    void weigh(int x, int y, const glm::vec4& sensitivity, const glm::vec4& channelWeights) {
        float sum = sensitivity.x + sensitivity.y + sensitivity.z + sensitivity.w;
        if (!std::isfinite(sum)) sum = 0;  // light beyond what floats square
        const float unit = channelWeights.x + channelWeights.y + channelWeights.z + channelWeights.w;
        const float perKey = range_ / static_cast<float>(plan_.key + 1e-12);
        const float importance = plan_.objective ? source_.coverage.at(x, y) : source_.importance.at(x, y) * perKey * perKey;
        significance_.at(x, y) = std::clamp(importance * sum / unit, 1e-6f * source_.coverage.at(x, y), 1e12f);
    }
    std::size_t clusterAt(int x, int y) const {
        const glm::ivec2 owner = source_.owner.at(x, y);
        return model_.clusterAt(owner.x, owner.y);
    }

    /// A texel on its way: its coefficient 0 and its code are solved in turns.
    struct Texel {
        std::array<glm::vec3, lighting::kShCount> light;
        ErrorForm form;
        const CodeSpace* space = nullptr;
        const CodeTable* table = nullptr;
        glm::vec3 dc{0};

        BasisTarget target() const { return {ratiosTo(light, dc), RatioCost(form, dc)}; }
    };
    struct Solved {
        SolvedCode code;
        glm::vec4 sensitivity{0};
    };
    Texel texelAt(int x, int y) {
        const std::size_t cluster = clusterAt(x, y);
        Texel texel{source_.lightAt(x, y, range_), formAt(x, y), &spaces_[cluster], &model_.code[cluster]};
        texel.dc = glm::max(texel.light[0], 0.0f);
        return texel;
    }
    /// Returns the code that follows from a first one and the coefficient 0 that suits it.
    Solved refined(Texel& texel, const SolvedCode& first) const {
        texel.dc = solveDc(texel.form, texel.light, evaluateCode(*texel.table, model_.shape.monomialCount(), first.code));
        const BasisTarget target = texel.target();
        const SolvedCode second = texel.space->solve(target, first.code);
        return {second, texel.space->sensitivity(target, second.code)};
    }

    void encodeCodes() {
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(0.5f, 0.5f, 0.5f, 1));
        for (int y = 0; y < source_.height; ++y) {
            float leftShare = 0;  // error of the left neighbour's code over its light
            for (int x = 0; x < source_.width; ++x) {
                if (!(source_.coverage.at(x, y) > 0)) continue;
                const bool hasLeft = x > 0 && source_.coverage.at(x - 1, y) > 0 && clusterAt(x - 1, y) == clusterAt(x, y);
                Texel texel = texelAt(x, y);
                const BasisTarget target = texel.target();
                const std::array<float, 3> weights = target.cost.channelWeights();
                const float light = weights[0] + weights[1] + weights[2] + 1e-30f;
                std::optional<Solved> solved;
                if (hasLeft) solved = refined(texel, texel.space->solve(target, texels.at(x - 1, y)));
                if (!solved || solved->code.error > kMuchWorse * leftShare * light) {
                    const Solved searched = refined(texel, texel.space->search(target));
                    if (!solved || searched.code.error < kClearlyBetter * solved->code.error) solved = searched;
                }
                texels.at(x, y) = solved->code.code;
                leftShare = solved->code.error / light;
                weigh(x, y, solved->sensitivity, model_.codeWeights);
            }
        }
        codes_ = encodeTexels(1, texels, model_.codeWeights, true);
    }

    /// Encodes the coefficient 0 that suits the decoded codes best.
    void encodeL0() {
        const auto ratiosAt = [&](int x, int y) {
            return evaluateCode(model_.code[clusterAt(x, y)], model_.shape.monomialCount(), codes_.at(x, y));
        };
        Image<glm::vec3> dc(source_.width, source_.height, glm::vec3(0));
        rows::forEachPadded(
            source_, [&](int x, int y) { dc.at(x, y) = range_ * solveDc(formAt(x, y), source_.lightAt(x, y, range_), ratiosAt(x, y)); });
        rows::Layer l0 = rows::encodeHdr(plan_, source_, dc, range_, options_, true, out_.report);
        out_.textures[0].layers.push_back(std::move(l0.bytes));
        dc_ = std::move(l0.decoded);
        if (model_.residual.empty()) return;
        rows::forEachPadded(source_, [&](int x, int y) {
            ratio_.at(x, y) = ratiosTo(source_.lightAt(x, y, range_), glm::vec3(dc_.at(x, y)));
            subtractCode(ratiosAt(x, y), ratio_.at(x, y));
        });
    }

    void encodeResidual(std::size_t layer) {
        const bool isLast = layer + 1 == model_.residual.size();
        const std::vector<ResidualTable>& tables = model_.residual[layer];
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(kResidualNeutral));
        rows::forEachPadded(source_, [&](int x, int y) {
            const ResidualTable& table = tables[clusterAt(x, y)];
            const BasisTarget target{ratio_.at(x, y), RatioCost(formAt(x, y), glm::vec3(dc_.at(x, y)))};
            texels.at(x, y) = solveResidual(table, target);
            weigh(x, y, residualSensitivity(table, target), model_.residualWeights[layer]);
        });
        const Image<glm::vec4> decoded = encodeTexels(2, texels, model_.residualWeights[layer], !isLast);
        if (isLast) return;
        rows::forEachPadded(source_, [&](int x, int y) { subtractResidual(tables[clusterAt(x, y)], decoded.at(x, y), ratio_.at(x, y)); });
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
    float range_;  ///< of coefficient 0: all light below is over it
    ShadingForm& shading_;
    const std::vector<CodeSpace>& spaces_;  ///< [cluster]
    std::vector<PackedForm> forms_;         ///< of covered and padded texels
    Image<glm::vec4> codes_;                ///< decoded
    Image<glm::vec4> dc_;                   ///< decoded coefficient 0 over range
    Image<ByChannel> ratio_;                ///< still to be coded, over the decoded coefficient 0
    Image<float> significance_;
};

}  // namespace

namespace rows {

EncodedLightMapRows encodeBasis(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source,
                                const EncodeOptions& options) {
    BasisContext context(plan, strip, options);
    EncodedLightMapRows out;
    out.textures.resize(plan.textures.size());
    for (int first = 0; first < source.height; first += plan.blockHeight()) {
        const Source part = source.rowsFrom(first, std::min(plan.blockHeight(), source.height - first));
        const EncodedLightMapRows encoded = BasisRows(context, part).run();
        for (std::size_t texture = 0; texture < out.textures.size(); ++texture) {
            auto& layers = out.textures[texture].layers;
            layers.resize(encoded.textures[texture].layers.size());
            for (std::size_t layer = 0; layer < layers.size(); ++layer)
                layers[layer].insert(layers[layer].end(), encoded.textures[texture].layers[layer].begin(),
                                     encoded.textures[texture].layers[layer].end());
        }
        out.report.add(encoded.report);
    }
    return out;
}

}  // namespace rows

}  // namespace lightcook::compress
