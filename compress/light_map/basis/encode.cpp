// Layouts "basis-K": the plan, which learns, and the rows, which solve each texel for its numbers.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "compress/light_map.h"
#include "compress/light_map/basis/code_solver.h"
#include "compress/light_map/basis/fit.h"
#include "compress/light_map/basis/model.h"
#include "compress/light_map/rows.h"

namespace lightcook::compress {

namespace {

using formats::Image;

constexpr std::size_t kCount = lighting::kShCount;
constexpr int kMostClusters = 64;
/// The tables of all clusters may take this share of the textures.
constexpr std::size_t kTableShare = 8;

BasisShape shapeOf(formats::LightMapLayout layout) {
    const formats::LightMapLayoutInfo& row = formats::info(layout);
    return {row.codeCount, row.residualCount()};
}

/// How often a cluster comes in a row: [cluster, count, cluster, count ...] over the blocks of the map, row by row.
std::vector<float> runsOf(const std::vector<std::uint8_t>& clusters) {
    std::vector<float> runs;
    for (std::size_t i = 0; i < clusters.size();) {
        std::size_t end = i;
        // A float counts to 2^24 exactly.
        while (end < clusters.size() && clusters[end] == clusters[i] && end - i < (std::size_t{1} << 24)) ++end;
        runs.push_back(clusters[i]);
        runs.push_back(static_cast<float>(end - i));
        i = end;
    }
    return runs;
}

/// Returns how many clusters cost at most 1 / kTableShare of the textures "l0" and "code". The residual does not count, so that a layout
/// with one begins with the same clusters and codes as the layout without.
int defaultClusterCount(const LightMapPlan& plan, const BasisShape& shape) {
    BasisModel one;
    one.shape = {shape.codeChannels, 0};
    one.code.resize(1);
    std::size_t bytes = 0;
    for (std::size_t t = 0; t < 2; ++t) bytes += formats::bytesPerImage(plan.textures[t].format, plan.width, plan.height);
    return std::clamp(static_cast<int>(bytes / kTableShare / one.tableBytes()), 1, kMostClusters);
}

/// The tables as the shader's structs have them: [cluster][monomial][coefficient 1 .. 8][rgb], [layer][cluster][channel][coefficient][rgb].
void writeConstants(const BasisModel& model, std::map<std::string, std::vector<float>>& constants) {
    constants["clusters"] = {static_cast<float>(model.clusterCount())};
    constants["neutral"] = {kResidualNeutral};
    constants["index_runs"] = runsOf(model.clusterOfBlock);
    std::vector<float>& code = constants["code"];
    for (const CodeTable& table : model.code)
        for (std::size_t m = 0; m < static_cast<std::size_t>(model.shape.monomialCount()); ++m)
            for (std::size_t i = 0; i < 8; ++i)
                for (std::size_t c = 0; c < 3; ++c) code.push_back(table[m][c][i]);
    std::vector<float>& residual = constants["residual"];
    for (const auto& layer : model.residual)
        for (const ResidualTable& table : layer)
            for (const ByChannel& channel : table)
                for (std::size_t i = 0; i < kCount; ++i)
                    for (std::size_t c = 0; c < 3; ++c) residual.push_back(channel[c][i]);
}

/// One band on its way through the stages.
class BasisRows {
public:
    BasisRows(const LightMapPlan& plan, const formats::LightMapStrip& band, const rows::Source& source, const EncodeOptions& options)
        : plan_(plan),
          model_(*plan.basis),
          band_(band),
          source_(source),
          options_(options),
          seen_(model_.clusterCount()),
          left_(source.width, source.height),
          significance_(source.width, source.height, 0) {}

    EncodedLightMapRows run() {
        out_.textures.resize(plan_.textures.size());
        encodeL0();
        encodeCode();
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
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x) {
                if (!(source_.coverage.at(x, y) > 0)) continue;
                // Coefficient 0 over the key, made small where light is bright: an error of the code is seen through it.
                const glm::vec3 stored(dc_.at(x, y));
                const float unit = range / static_cast<float>(plan_.key + 1e-12), local = std::sqrt(source_.importance.at(x, y));
                const float seen = std::min(local * unit * glm::length(stored), 1e6f);
                significance_.at(x, y) = std::max(seen * seen, 1e-6f * source_.coverage.at(x, y));
                ByChannel& left = left_.at(x, y);
                for (std::size_t c = 0; c < 3; ++c) {
                    const float decoded = range * stored[static_cast<int>(c)];
                    for (std::size_t i = 0; i < kCount; ++i)
                        left[c][i] = decoded > 0 ? std::clamp(source_.values[i].at(x, y)[static_cast<int>(c)] / decoded, -4.0f, 4.0f) : 0;
                    if (!(decoded > 0)) left[c][0] = 1;
                }
            }
    }

    /// What texels of a cluster share as long as their normal stays: rows cross many charts, and come back to each.
    struct Seen {
        glm::vec3 normal{0};
        Metric metric;
        std::optional<CodeSpace> space;
    };
    Seen& seenAt(int x, int y) {
        const glm::ivec2 owner = source_.owner.at(x, y);
        const glm::vec3& normal = band_.normal.at(owner.x, owner.y - band_.firstRow);
        const std::size_t cluster = clusterAt(x, y);
        Seen& seen = seen_[cluster];
        if (!seen.space || seen.normal != normal) {
            seen.normal = normal;
            seen.metric = metrics_.at(normal);
            seen.space.emplace(model_.code[cluster], model_.shape, seen.metric, model_.seeds[cluster]);
        }
        return seen;
    }
    BasisTarget targetAt(int x, int y, const Seen& seen) const {
        const glm::vec3 dc(dc_.at(x, y));
        return {left_.at(x, y), {dc.x * dc.x, dc.y * dc.y, dc.z * dc.z}, &seen.metric};
    }
    std::size_t clusterAt(int x, int y) const {
        const glm::ivec2 owner = source_.owner.at(x, y);
        return model_.clusterAt(owner.x, owner.y);
    }

    /// Each texel starts from its left neighbour's code: one that goes on where it was is cheap to compress. Where that serves it worse
    /// than it served the neighbour, the cluster's seeds are tried too.
    void encodeCode() {
        constexpr float kAsGood = 1.1f, kWorthLeaving = 0.9f;
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(0.5f, 0.5f, 0.5f, 1));
        for (int y = 0; y < source_.height; ++y) {
            float leftShare = 0;  // what the left neighbour's code misses, of its light
            for (int x = 0; x < source_.width; ++x) {
                if (!(source_.coverage.at(x, y) > 0)) continue;
                Seen& seen = seenAt(x, y);
                const BasisTarget target = targetAt(x, y, seen);
                const float light = target.weight[0] + target.weight[1] + target.weight[2] + 1e-30f;
                const std::size_t cluster = clusterAt(x, y);
                std::optional<SolvedCode> solved;
                if (x > 0 && source_.coverage.at(x - 1, y) > 0 && clusterAt(x - 1, y) == cluster)
                    solved = seen.space->solve(target, texels.at(x - 1, y));
                if (!solved || solved->error > kAsGood * leftShare * light) {
                    const SolvedCode searched = seen.space->search(target);
                    if (!solved || searched.error < kWorthLeaving * solved->error) solved = searched;
                }
                texels.at(x, y) = solved->code;
                leftShare = solved->error / light;
            }
        }
        const Image<glm::vec4> decoded = encodeTexels(1, texels, model_.codeWeights, true);
        for (int y = 0; y < source_.height && !model_.residual.empty(); ++y)
            for (int x = 0; x < source_.width; ++x) {
                if (!(source_.coverage.at(x, y) > 0)) continue;
                const HigherByChannel coded = evaluateCode(model_.code[clusterAt(x, y)], model_.shape.monomialCount(), decoded.at(x, y));
                ByChannel& left = left_.at(x, y);
                for (std::size_t c = 0; c < 3; ++c) {
                    left[c][0] -= 1;
                    for (std::size_t i = 0; i < 8; ++i) left[c][i + 1] -= coded[c][i];
                }
            }
    }

    void encodeResidual(std::size_t layer) {
        const bool isLast = layer + 1 == model_.residual.size();
        Image<glm::vec4> texels(source_.width, source_.height, glm::vec4(kResidualNeutral));
        for (int y = 0; y < source_.height; ++y)
            for (int x = 0; x < source_.width; ++x)
                if (source_.coverage.at(x, y) > 0)
                    texels.at(x, y) = solveResidual(model_.residual[layer][clusterAt(x, y)], targetAt(x, y, seenAt(x, y)));
        const Image<glm::vec4> decoded = encodeTexels(2, texels, model_.residualWeights[layer], !isLast);
        for (int y = 0; y < source_.height && !isLast; ++y)
            for (int x = 0; x < source_.width; ++x) {
                if (!(source_.coverage.at(x, y) > 0)) continue;
                ByChannel taken{};
                addResidual(model_.residual[layer][clusterAt(x, y)], decoded.at(x, y), taken);
                for (std::size_t c = 0; c < 3; ++c)
                    for (std::size_t i = 0; i < kCount; ++i) left_.at(x, y)[c][i] -= taken[c][i];
            }
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
    const formats::LightMapStrip& band_;
    const rows::Source& source_;
    const EncodeOptions& options_;
    EncodedLightMapRows out_;
    ShadingMetric metrics_;
    std::vector<Seen> seen_;  ///< [cluster]
    Image<glm::vec4> dc_;     ///< decoded coefficient 0 over range
    Image<ByChannel> left_;   ///< what is still to be coded, over it
    Image<float> significance_;
};

}  // namespace

std::size_t LightMapPlan::gpuBytesAs(formats::LightMapLayout shorter) const {
    if (shorter == layout) return gpuBytes();
    assert(basis && shapeOf(shorter).codeChannels == basis->shape.codeChannels &&
           shapeOf(shorter).residualLayers <= basis->shape.residualLayers);
    const int dropped = basis->shape.residualLayers - shapeOf(shorter).residualLayers;
    return gpuBytes() - static_cast<std::size_t>(dropped) * (formats::bytesPerImage(textures[2].format, width, height) +
                                                             basis->clusterCount() * BasisModel::kResidualTableBytes);
}

int learningBlocks(int effort, int width, int height) {
    const double megapixels = static_cast<double>(width) * height / (1 << 20);
    return static_cast<int>((1000 + 500 * effort) * std::clamp(megapixels, 1.0, 4.0));
}

LightMapPlan planLearnedLightMap(formats::LightMapLayout layout, formats::Target target, int width, int height,
                                 const LightMapMeasure& measure, const LightMapBlocks& blocks, const std::vector<int>& charts,
                                 const LightMapSamples& samples, int clusters, const EncodeOptions& options) {
    assert(formats::info(layout).isLearned());
    const BasisShape shape = shapeOf(layout);
    LightMapPlan plan = rows::emptyPlan(layout, target, width, height, measure);
    plan.constants["range"] = {rows::halfRange(measure.maximumAbsolute(0))};
    if (clusters == 0) clusters = defaultClusterCount(plan, shape);
    auto model = std::make_shared<BasisModel>(fitBasis(plan, shape, samples, charts, blocks.across(), clusters, options));
    writeConstants(*model, plan.constants);
    plan.basis = std::move(model);
    return plan;
}

namespace rows {

EncodedLightMapRows encodeBasis(const LightMapPlan& plan, const formats::LightMapStrip& band, const Source& source,
                                const EncodeOptions& options) {
    return BasisRows(plan, band, source, options).run();
}

}  // namespace rows

}  // namespace lightcook::compress
