#include "compress/light_map/basis/sample.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "compress/light_map/basis/parallel.h"

namespace lightcook::compress {

namespace {

using formats::Image;

/// Share of the total weight of a sample that goes to absolute squared errors, by objective.
constexpr double kSquaresOfVisible = 0.3, kSquaresOfEnergy = 0.5;
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
    rows::dropFarPadding(all, kChartBlock);
    return all;
}

}  // namespace

BasisSample::BasisSample(const LightMapPlan& plan, const LightMapSamples& samples, const EncodeOptions& options)
    : plan_(plan), samples_(samples), options_(options), source_(sourceOf(plan, samples)) {
    lightSquare_ = measureLight();
    collect();
    addSquareWeights(plan.objective ? kSquaresOfVisible : kSquaresOfEnergy);
    sortIntoClusters(1);
}

double BasisSample::measureLight() const {
    const float range = rows::constant(plan_, "range", 0);
    double sum = 0, weights = 0;
    for (int x = 0; x < source_.width; ++x)
        for (int y = 0; y < kChartBlock; ++y) {
            if (source_.coverage.at(x, y) < 1) continue;
            const glm::dvec3 dc(source_.lightAt(x, y, range)[0]);
            const auto weight = static_cast<double>(blockWeight(x));
            sum += weight * glm::dot(dc, dc) / 3;
            weights += weight;
        }
    return weights > 0 ? sum / weights : 0;
}

void BasisSample::collect() {
    const float range = rows::constant(plan_, "range", 0);
    const bool isVisible = plan_.objective.has_value();
    texels_.reserve(static_cast<std::size_t>(source_.width) * static_cast<std::size_t>(kChartBlock));
    for (int x = 0; x < source_.width; ++x)
        for (int y = 0; y < kChartBlock; ++y) {
            if (source_.coverage.at(x, y) < 1) continue;
            SampleTexel texel{x, y};
            texel.light = source_.lightAt(x, y, range);
            texel.weight = blockWeight(x) * (isVisible ? 1.0f : std::sqrt(source_.importance.at(x, y)));
            texels_.push_back(texel);
        }
    measureForms(ShadingForm(plan_.objective, static_cast<double>(range), lightSquare_));
}

/// Sets the forms of all texels, and coefficients 0 to those of the reference.
void BasisSample::measureForms(const ShadingForm& shading) {
    constexpr std::size_t kTogether = 256;  // neighbours, which often have the same normal
    forEachInParallel((texels_.size() + kTogether - 1) / kTogether, [&](std::size_t part) {
        ShadingForm own = shading;
        for (std::size_t i = part * kTogether; i < std::min((part + 1) * kTogether, texels_.size()); ++i) {
            SampleTexel& texel = texels_[i];
            const glm::ivec2 owner = source_.owner.at(texel.x, texel.y);
            texel.form = own.at(texel.light, samples_.texels().normal.at(owner.x, owner.y));
            setDc(texel, glm::max(texel.light[0], 0.0f));
        }
    });
}

void BasisSample::setDc(SampleTexel& texel, const glm::vec3& dc) {
    texel.dc = dc;
    texel.ratio = ratiosTo(texel.light, dc);
    texel.channelWeights = channelWeightsOf(texel.form, dc);
}

/// Adds a weight in proportion to the squared light of each texel. The weights before count relative errors, but the figure rel_rms counts
/// absolute ones. The difference matters where a few texels of a light source hold nearly all light of the map.
/// share  of the total weight that the added weights get
void BasisSample::addSquareWeights(double share) {
    const auto squareOf = [](const SampleTexel& texel) {
        double sum = 0;
        for (const glm::vec3& coefficient : texel.light) sum += static_cast<double>(glm::dot(coefficient, coefficient));
        return sum;
    };
    double relative = 0, squares = 0;
    for (const SampleTexel& texel : texels_) {
        relative += static_cast<double>(texel.totalWeight());
        squares += static_cast<double>(blockWeight(texel.x)) * squareOf(texel);
    }
    if (!(squares > 0)) return;
    const double unit = share / (1 - share) * relative / squares;
    for (SampleTexel& texel : texels_)
        if (texel.totalCost() > 0)
            texel.weight += static_cast<float>(unit * squareOf(texel) / static_cast<double>(texel.totalCost())) * blockWeight(texel.x);
}

/// Returns the number of blocks of the map that a texel's block stands for.
float BasisSample::blockWeight(int x) const {
    return samples_.choices()[static_cast<std::size_t>(x / kChartBlock)].weight;
}

int BasisSample::blockOf(const SampleTexel& texel) const {
    return samples_.choices()[static_cast<std::size_t>(texel.x / kChartBlock)].block;
}

void BasisSample::sortIntoClusters(int count) {
    clusters_.assign(static_cast<std::size_t>(count), {});
    for (SampleTexel& texel : texels_) clusters_[static_cast<std::size_t>(texel.cluster)].push_back(&texel);
}

void BasisSample::encodeDc() {
    const float range = rows::constant(plan_, "range", 0);
    Image<glm::vec3> dc(source_.width, source_.height, glm::vec3(0));
    for (const SampleTexel& texel : texels_) dc.at(texel.x, texel.y) = range * texel.dc;
    EncodeReport report;
    const rows::Layer l0 = rows::encodeHdr(plan_, source_, dc, range, options_, true, report);
    for (SampleTexel& texel : texels_) setDc(texel, glm::vec3(l0.decoded.at(texel.x, texel.y)));
}

void BasisSample::encodeCodes(std::size_t texture, const glm::vec4& channelWeights) {
    Image<glm::vec4> image(source_.width, source_.height, glm::vec4(0.5f));
    Image<float> significance(source_.width, source_.height, 0);
    for (const SampleTexel& texel : texels_) {
        image.at(texel.x, texel.y) = texel.code;
        significance.at(texel.x, texel.y) =
            (plan_.objective ? 1.0f : source_.importance.at(texel.x, texel.y)) * std::max(texel.totalCost(), 1e-20f);
    }
    EncodeOptions options = options_;
    for (int k = 0; k < 4; ++k) options.channelWeights[static_cast<std::size_t>(k)] = channelWeights[k];
    EncodeReport report;
    const rows::Layer layer = rows::encodeLayer(plan_.textures[texture].format, image, significance, options, true, report);
    for (SampleTexel& texel : texels_) texel.code = layer.decoded.at(texel.x, texel.y);
}

ByChannel ratiosTo(std::span<const glm::vec3> light, const glm::vec3& dc) {
    ByChannel out{};
    for (int c = 0; c < 3; ++c) {
        std::array<float, kCoefficientCount>& ratio = out[static_cast<std::size_t>(c)];
        if (!(dc[c] > 0)) {
            ratio[0] = 1;
            continue;
        }
        for (std::size_t i = 0; i < kCoefficientCount; ++i) ratio[i] = std::clamp(light[i][c] / dc[c], -4.0f, 4.0f);
    }
    return out;
}

glm::vec4 channelWeightsOf(const glm::dvec4& sensitivity) {
    const double largest = std::max({sensitivity.x, sensitivity.y, sensitivity.z, sensitivity.w});
    return largest > 0 && std::isfinite(sensitivity.x + sensitivity.y + sensitivity.z + sensitivity.w)
               ? glm::vec4(glm::max(sensitivity / largest, glm::dvec4(1e-3)))
               : glm::vec4(1);
}

}  // namespace lightcook::compress
