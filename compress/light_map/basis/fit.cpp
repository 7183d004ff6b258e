#include "compress/light_map/basis/fit.h"

#include <algorithm>
#include <cassert>

#include "compress/light_map/basis/clusters.h"
#include "compress/light_map/basis/code_fit.h"
#include "compress/light_map/basis/error_space.h"
#include "compress/light_map/basis/residual_fit.h"
#include "compress/light_map/basis/sample.h"

namespace lightcook::compress {

namespace {

/// Returns the texels that clusters are found from: about a third, and the first of each chart.
std::vector<SampleTexel*> thinned(BasisSample& sample, const std::vector<int>& charts) {
    std::vector<SampleTexel*> out;
    int lastChart = -1;
    for (SampleTexel& texel : sample.texels()) {
        const int chart = charts[static_cast<std::size_t>(sample.blockOf(texel))];
        if ((texel.x + texel.y) % 3 == 0 || out.empty() || chart != lastChart) out.push_back(&texel);
        lastChart = chart;
    }
    return out;
}

/// Returns the cluster of each chart.
std::vector<int> clustersOf(BasisSample& sample, const std::vector<int>& charts, int codeChannels, int clusterCount) {
    const std::vector<SampleTexel*> texels = thinned(sample, charts);
    SamplePoints points = pointsOf(ErrorSpace(sample, sample.clusters().front(), 1), texels);
    ChartPoints chartPoints{std::move(points.points), std::move(points.weights), {}, 0};
    for (const SampleTexel* texel : texels) chartPoints.chartOf.push_back(charts[static_cast<std::size_t>(sample.blockOf(*texel))]);
    for (const int chart : charts) chartPoints.chartCount = std::max(chartPoints.chartCount, chart + 1);
    return clusterCharts(chartPoints, codeChannels, clusterCount);
}

/// Assigns a cluster to each chart, block and texel.
void assignClusters(BasisSample& sample, const std::vector<int>& charts, int clusterCount, BasisModel& model) {
    const std::vector<int> clusters = clustersOf(sample, charts, model.shape.codeChannels, clusterCount);
    int count = 1;
    for (const int cluster : clusters) count = std::max(count, cluster + 1);
    model.code.assign(static_cast<std::size_t>(count), CodeTable{});
    model.clusterOfBlock.resize(charts.size());
    int last = 0;  // a block without light keeps the cluster of the block before it: fewer runs
    for (std::size_t block = 0; block < charts.size(); ++block) {
        if (charts[block] >= 0) last = clusters[static_cast<std::size_t>(charts[block])];
        model.clusterOfBlock[block] = static_cast<std::uint8_t>(last);
    }
    for (SampleTexel& texel : sample.texels())
        texel.cluster = clusters[static_cast<std::size_t>(charts[static_cast<std::size_t>(sample.blockOf(texel))])];
    sample.sortIntoClusters(count);
}

}  // namespace

BasisModel fitBasis(const LightMapPlan& plan, const BasisShape& shape, const LightMapSamples& samples, const std::vector<int>& charts,
                    int blocksAcross, int clusterCount, const EncodeOptions& options) {
    assert(clusterCount >= 1 && clusterCount <= 256);
    BasisModel model;
    model.shape = shape;
    model.blocksAcross = blocksAcross;
    BasisSample sample(plan, samples, options);
    assignClusters(sample, charts, clusterCount, model);
    fitCodes(sample, model);
    for (int layer = 0; layer < shape.residualLayers; ++layer) addResidualLayer(sample, model);
    return model;
}

}  // namespace lightcook::compress
