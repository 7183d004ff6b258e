#include "compress/light_map/basis/fit.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

#include "compress/light_map/basis/clusters.h"
#include "compress/light_map/basis/code_fit.h"
#include "compress/light_map/basis/error_space.h"
#include "compress/light_map/basis/residual_fit.h"
#include "compress/light_map/basis/sample.h"

namespace lightcook::compress {

namespace {

/// Returns the texels that clusters are computed from: about a third of the sample, and the first of each chart.
std::vector<SampleTexel*> thinned(BasisSample& sample, const std::vector<int>& chartOfBlock) {
    std::vector<SampleTexel*> out;
    int lastChart = -1;
    for (SampleTexel& texel : sample.texels()) {
        const int chart = chartOfBlock[static_cast<std::size_t>(sample.blockOf(texel))];
        if ((texel.x + texel.y) % 3 == 0 || out.empty() || chart != lastChart) out.push_back(&texel);
        lastChart = chart;
    }
    return out;
}

/// Returns the cluster of each chart.
std::vector<int> clustersOf(BasisSample& sample, const std::vector<int>& chartOfBlock, int codeChannels, int clusterCount) {
    const std::vector<SampleTexel*> texels = thinned(sample, chartOfBlock);
    SamplePoints points = pointsOf(ErrorSpace(sample.clusters().front(), 1), texels);
    ChartPoints chartPoints{std::move(points.points), std::move(points.weights), {}, 0};
    for (const SampleTexel* texel : texels) chartPoints.chartOf.push_back(chartOfBlock[static_cast<std::size_t>(sample.blockOf(*texel))]);
    for (const int chart : chartOfBlock) chartPoints.chartCount = std::max(chartPoints.chartCount, chart + 1);
    return clusterCharts(chartPoints, codeChannels, clusterCount);
}

/// Returns the chart of a block, or of the first neighbour that has one: across, down, then diagonally. -1 without any.
int chartBeside(const std::vector<int>& chartOfBlock, int block, int blocksAcross) {
    constexpr std::array<std::pair<int, int>, 9> kSteps = {{{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
    const int x = block % blocksAcross, y = block / blocksAcross, rows = static_cast<int>(chartOfBlock.size()) / blocksAcross;
    for (const auto& [dx, dy] : kSteps) {
        if (x + dx < 0 || x + dx >= blocksAcross || y + dy < 0 || y + dy >= rows) continue;
        if (const int chart = chartOfBlock[static_cast<std::size_t>((y + dy) * blocksAcross + x + dx)]; chart >= 0) return chart;
    }
    return -1;
}

/// Assigns a cluster to each chart, block and texel.
void assignClusters(BasisSample& sample, const std::vector<int>& chartOfBlock, int clusterCount, BasisModel& model) {
    const std::vector<int> clusters = clustersOf(sample, chartOfBlock, model.shape.codeChannels, clusterCount);
    int count = 1;
    for (const int cluster : clusters) count = std::max(count, cluster + 1);
    model.code.assign(static_cast<std::size_t>(count), CodeTable{});
    model.clusterOfBlock.resize(chartOfBlock.size());
    // A block without a chart has the cluster of a chart beside it, whose surface may reach half a texel into the block; else that of the
    // block before it, which gives fewer runs.
    int last = 0;
    for (std::size_t block = 0; block < chartOfBlock.size(); ++block) {
        if (const int chart = chartBeside(chartOfBlock, static_cast<int>(block), model.blocksAcross); chart >= 0)
            last = clusters[static_cast<std::size_t>(chart)];
        model.clusterOfBlock[block] = static_cast<std::uint8_t>(last);
    }
    for (SampleTexel& texel : sample.texels())
        texel.cluster = clusters[static_cast<std::size_t>(chartOfBlock[static_cast<std::size_t>(sample.blockOf(texel))])];
    sample.sortIntoClusters(count);
}

}  // namespace

BasisModel fitBasis(const LightMapPlan& plan, const BasisShape& shape, const LightMapTraining& training, int clusterCount,
                    const EncodeOptions& options) {
    assert(clusterCount >= 1 && clusterCount <= 256);
    BasisModel model;
    model.shape = shape;
    model.blocksAcross = training.samples.blocksAcross();
    BasisSample sample(plan, training.samples, options);
    model.lightSquare = sample.lightSquare();
    assignClusters(sample, training.chartOfBlock, clusterCount, model);
    fitCodes(sample, model);
    for (int layer = 0; layer < shape.residualLayers; ++layer) addResidualLayer(sample, model);
    return model;
}

}  // namespace lightcook::compress
