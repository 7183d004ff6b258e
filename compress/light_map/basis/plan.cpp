// Plan of the layouts basis-K: count of clusters, the fit, and the learned tables as constants.
#include <algorithm>
#include <cassert>

#include "compress/light_map/basis/fit.h"
#include "compress/light_map/families.h"
#include "compress/texel/half.h"

namespace lightcook::compress {

namespace {

constexpr int kMaxClusters = 64;
/// The code tables of all clusters take at most 1 / kTableShare of the bytes of l0 and code.
constexpr std::size_t kTableShare = 6;

BasisShape shapeOf(formats::LightMapLayout layout) {
    const formats::LightMapLayoutInfo& row = formats::info(layout);
    return {row.codeCount, row.residualCount()};
}

/// Returns the count of clusters for a plan that names none. The residual does not count, so that a layout with one has the same clusters
/// and codes as the layout without.
int defaultClusterCount(const LightMapPlan& plan, const BasisShape& shape) {
    BasisModel one;
    one.shape = {shape.codeChannels, 0};
    one.code.resize(1);
    std::size_t bytes = 0;
    for (std::size_t t = 0; t < 2; ++t) bytes += formats::bytesPerImage(plan.textures[t].format, plan.width, plan.height);
    return std::clamp(static_cast<int>(bytes / kTableShare / one.tableBytes()), 1, kMaxClusters);
}

/// Returns the clusters of all blocks, row by row, run-length encoded: [cluster, count, cluster, count ...].
std::vector<float> runsOf(const std::vector<std::uint8_t>& clusters) {
    constexpr std::size_t kLongestRun = std::size_t{1} << 24;  // floats count to it exactly
    std::vector<float> runs;
    for (std::size_t i = 0; i < clusters.size();) {
        std::size_t end = i;
        while (end < clusters.size() && clusters[end] == clusters[i] && end - i < kLongestRun) ++end;
        runs.push_back(clusters[i]);
        runs.push_back(static_cast<float>(end - i));
        i = end;
    }
    return runs;
}

/// Writes the tables in the order of the shader's structs: code [cluster][monomial][coefficient 1 to 8][rgb],
/// residual [layer][cluster][channel][coefficient][rgb].
void writeConstants(const BasisModel& model, std::map<std::string, std::vector<float>>& constants) {
    constants["clusters"] = {static_cast<float>(model.clusterCount())};
    constants["neutral"] = {kResidualNeutral};
    constants["index_runs"] = runsOf(model.clusterOfBlock);
    std::vector<float>& code = constants["code"];
    code.clear();
    for (const CodeTable& table : model.code)
        for (std::size_t m = 0; m < static_cast<std::size_t>(model.shape.monomialCount()); ++m)
            for (std::size_t i = 0; i < 8; ++i)
                for (std::size_t c = 0; c < 3; ++c) code.push_back(table[m][c][i]);
    std::vector<float>& residual = constants["residual"];
    residual.clear();
    for (const auto& layer : model.residual)
        for (const ResidualTable& table : layer)
            for (const ByChannel& channel : table)
                for (std::size_t i = 0; i < kCoefficientCount; ++i)
                    for (std::size_t c = 0; c < 3; ++c) residual.push_back(channel[c][i]);
}

}  // namespace

LightMapPlan LightMapPlan::shortenedTo(formats::LightMapLayout shorter) const {
    const formats::LightMapLayoutInfo& row = formats::info(shorter);
    assert(basis && shapeOf(shorter).codeChannels == basis->shape.codeChannels);
    LightMapPlan plan = *this;
    plan.layout = shorter;
    plan.textures.resize(row.textures.size());
    for (std::size_t i = 0; i < plan.textures.size(); ++i) plan.textures[i].layerCount = row.textures[i].layerCount;
    auto model = std::make_shared<BasisModel>(*basis);
    const auto layers = static_cast<std::size_t>(row.residualCount());
    model->shape = shapeOf(shorter);
    model->residual.resize(layers);
    model->residualWeights.resize(layers);
    writeConstants(*model, plan.constants);
    plan.basis = std::move(model);
    return plan;
}

std::size_t LightMapPlan::gpuBytesAs(formats::LightMapLayout shorter) const {
    assert(formats::info(shorter).family == formats::info(layout).family);
    std::size_t dropped = 0;
    for (std::size_t i = 0; i < textures.size(); ++i) {
        const auto kept = formats::info(shorter).textures;
        const int layers = textures[i].layerCount - (i < kept.size() ? kept[i].layerCount : 0);
        dropped += static_cast<std::size_t>(layers) * layerBytes(textures[i]);
    }
    return gpuBytes() - dropped - (tableBytes() - tableBytesAs(shorter));
}

std::size_t LightMapPlan::tableBytesAs(formats::LightMapLayout shorter) const {
    if (!basis) return 0;
    assert(shapeOf(shorter).codeChannels == basis->shape.codeChannels);
    const int dropped = basis->shape.residualLayers - shapeOf(shorter).residualLayers;
    return basis->tableBytes() - static_cast<std::size_t>(dropped) * basis->clusterCount() * BasisModel::kResidualTableBytes;
}

int LightMapPlan::tableColumns() const {
    return basis ? static_cast<int>(basis->tableBytes() / basis->clusterCount() / BasisModel::kFactorBytes) : 0;
}

std::vector<std::byte> LightMapPlan::tableTexels() const {
    std::vector<std::uint16_t> halves;
    const auto addFactor = [&](const auto& byChannel, std::size_t i) {
        for (std::size_t c = 0; c < 3; ++c) halves.push_back(halfFromFloat(byChannel[c][i]));
        halves.push_back(0);
    };
    for (std::size_t cluster = 0; basis && cluster < basis->clusterCount(); ++cluster) {
        for (std::size_t m = 0; m < static_cast<std::size_t>(basis->shape.monomialCount()); ++m)
            for (std::size_t i = 0; i < 8; ++i) addFactor(basis->code[cluster][m], i);
        for (const auto& layer : basis->residual)
            for (const ByChannel& channel : layer[cluster])
                for (std::size_t i = 0; i < kCoefficientCount; ++i) addFactor(channel, i);
    }
    const auto bytes = std::as_bytes(std::span(halves));
    return {bytes.begin(), bytes.end()};
}

int learningBlocks(int effort, int width, int height) {
    const double megapixels = static_cast<double>(width) * height / (1 << 20);
    return static_cast<int>((1000 + 500 * effort) * std::clamp(megapixels, 1.0, 4.0));
}

LightMapPlan planLearnedLightMap(formats::LightMapLayout layout, const MeasuredLightMap& map, const LightMapTraining& training,
                                 const EncodeOptions& options) {
    assert(formats::info(layout).isLearned());
    const BasisShape shape = shapeOf(layout);
    LightMapPlan plan = rows::emptyPlan(layout, map);
    plan.constants["range"] = {rows::halfRange(map.measure.maximumAbsolute(0))};
    const int clusters = training.clusters == 0 ? defaultClusterCount(plan, shape) : training.clusters;
    auto model = std::make_shared<BasisModel>(fitBasis(plan, shape, training, clusters, options));
    writeConstants(*model, plan.constants);
    plan.basis = std::move(model);
    return plan;
}

}  // namespace lightcook::compress
