#include "compress/light_map/basis/sample.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace lightcook::compress {

namespace {

using formats::Image;

constexpr std::size_t kCount = lighting::kShCount;
constexpr int kSide = LightMapSamples::kSide, kMargin = LightMapSamples::kMargin;

template <class T>
Image<T> columnsOf(const Image<T>& image, int first, int count) {
    Image<T> out(count, image.height());
    for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < count; ++x) out.at(x, y) = image.at(first + x, y);
    return out;
}
formats::LightMapStrip columnsOf(const formats::LightMapStrip& strip, int first, int count) {
    formats::LightMapStrip out;
    out.sh = columnsOf(strip.sh, first, count);
    out.covered = columnsOf(strip.covered, first, count);
    out.normal = columnsOf(strip.normal, first, count);
    return out;
}

/// Copies the blocks of a strip of samples, without their margins, to `out` from block `first` on.
template <class T>
void copyBlocks(const Image<T>& strip, Image<T>& out, int first) {
    for (int y = 0; y < kChartBlock; ++y)
        for (int x = 0; x < strip.width() / kSide * kChartBlock; ++x)
            out.at(first * kChartBlock + x, y) = strip.at(x / kChartBlock * kSide + kMargin + x % kChartBlock, kMargin + y);
}

/// Returns the chosen blocks side by side, padded as they are in the map. Works on some blocks at a time, since blocks with their margins
/// take four times the memory.
rows::Source sourceOf(const LightMapPlan& plan, const LightMapSamples& samples) {
    constexpr int kAtATime = 256;
    const int count = static_cast<int>(samples.choices().size());
    rows::Source all;
    all.width = count * kChartBlock;
    all.height = kChartBlock;
    all.coverage = Image<float>(all.width, all.height);
    all.importance = Image<float>(all.width, all.height);
    all.owner = Image<glm::ivec2>(all.width, all.height);
    for (int first = 0; first < count; first += kAtATime) {
        const int end = std::min(first + kAtATime, count);
        LightMapPlan part = plan;
        part.width = (end - first) * kSide;
        part.height = kSide;
        rows::Source wide = rows::makeSource(part, columnsOf(samples.texels(), first * kSide, part.width), 0, part.height);
        for (glm::ivec2& owner : wide.owner.texels()) owner.x += first * kSide;
        while (all.values.size() < wide.values.size()) all.values.emplace_back(all.width, all.height);
        for (std::size_t i = 0; i < wide.values.size(); ++i) copyBlocks(wide.values[i], all.values[i], first);
        copyBlocks(wide.coverage, all.coverage, first);
        copyBlocks(wide.importance, all.importance, first);
        copyBlocks(wide.owner, all.owner, first);
    }
    return all;
}

}  // namespace

BasisSample::BasisSample(const LightMapPlan& plan, const LightMapSamples& samples, const EncodeOptions& options)
    : plan_(plan), samples_(samples), options_(options), source_(sourceOf(plan, samples)) {
    collect();
    addSquareWeights();
    sortIntoClusters(1);
}

void BasisSample::collect() {
    const float range = rows::constant(plan_, "range", 0);
    EncodeReport report;
    const rows::Layer l0 =
        rows::encodeHdr(plan_.textures[0].format, source_, 0, range, static_cast<float>(plan_.key), options_, true, report);
    ShadingMetric metric;
    glm::vec3 lastNormal(0);
    for (int x = 0; x < source_.width; ++x)
        for (int y = 0; y < kChartBlock; ++y) {
            if (source_.coverage.at(x, y) < 1) continue;
            SampleTexel texel{x, y};
            texel.weight = blockWeight(texel) * std::sqrt(source_.importance.at(x, y));
            const glm::vec3 stored(l0.decoded.at(x, y));
            for (std::size_t c = 0; c < 3; ++c) texel.light[c] = stored[static_cast<int>(c)] * stored[static_cast<int>(c)];
            texel.ratio = ratiosTo(source_, x, y, range * stored);
            const glm::ivec2 owner = source_.owner.at(x, y);
            const glm::vec3& normal = samples_.texels().normal.at(owner.x, owner.y);
            if (metrics_.empty() || normal != lastNormal) metrics_.push_back(metric.at(normal));
            lastNormal = normal;
            texel.metric = metrics_.size() - 1;
            texels_.push_back(texel);
        }
}

/// The weights so far are relative: they follow visibility. rel_rms counts absolute squares. Half of the total weight goes to each. The
/// second half matters where a few texels of a light source hold nearly all light of the map.
void BasisSample::addSquareWeights() {
    double relative = 0, squares = 0;
    for (const SampleTexel& texel : texels_) {
        relative += static_cast<double>(texel.totalWeight());
        squares += static_cast<double>(blockWeight(texel) * texel.totalLight());
    }
    if (!(squares > 0)) return;
    const auto unit = static_cast<float>(relative / squares);
    for (SampleTexel& texel : texels_) texel.weight += unit * blockWeight(texel);
}

/// Returns the number of blocks of the map that a texel's block stands for.
float BasisSample::blockWeight(const SampleTexel& texel) const {
    return samples_.choices()[static_cast<std::size_t>(texel.x / kChartBlock)].weight;
}

int BasisSample::blockOf(const SampleTexel& texel) const {
    return samples_.choices()[static_cast<std::size_t>(texel.x / kChartBlock)].block;
}

void BasisSample::sortIntoClusters(int count) {
    clusters_.assign(static_cast<std::size_t>(count), {});
    for (SampleTexel& texel : texels_) clusters_[static_cast<std::size_t>(texel.cluster)].push_back(&texel);
}

void BasisSample::encodeCodes(std::size_t texture, const glm::vec4& channelWeights) {
    Image<glm::vec4> image(source_.width, source_.height, glm::vec4(0.5f));
    Image<float> significance(source_.width, source_.height, 0);
    for (const SampleTexel& texel : texels_) {
        image.at(texel.x, texel.y) = texel.code;
        significance.at(texel.x, texel.y) = source_.importance.at(texel.x, texel.y) * std::max(texel.totalLight(), 1e-20f);
    }
    EncodeOptions options = options_;
    for (int k = 0; k < 4; ++k) options.channelWeights[static_cast<std::size_t>(k)] = channelWeights[k];
    EncodeReport report;
    const rows::Layer layer = rows::encodeLayer(plan_.textures[texture].format, image, significance, options, true, report);
    for (SampleTexel& texel : texels_) texel.code = layer.decoded.at(texel.x, texel.y);
}

ByChannel ratiosTo(const rows::Source& source, int x, int y, const glm::vec3& decodedDc) {
    ByChannel out{};
    for (int c = 0; c < 3; ++c) {
        std::array<float, kCount>& ratio = out[static_cast<std::size_t>(c)];
        if (!(decodedDc[c] > 0)) {
            ratio[0] = 1;
            continue;
        }
        for (std::size_t i = 0; i < kCount; ++i) ratio[i] = std::clamp(source.values[i].at(x, y)[c] / decodedDc[c], -4.0f, 4.0f);
    }
    return out;
}

glm::vec4 channelWeightsOf(const glm::dvec4& sensitivity) {
    const double largest = std::max({sensitivity.x, sensitivity.y, sensitivity.z, sensitivity.w});
    return largest > 0 ? glm::vec4(glm::max(sensitivity / largest, glm::dvec4(1e-3))) : glm::vec4(1);
}

}  // namespace lightcook::compress
