// The sample that a learned layout is fitted to: the covered texels of the chosen blocks, and the stages that they have passed. Private to
// compress/.
//
// Each stage subtracts from `ratio` what its decoded texels give, so that the next one is fitted to the real error of the encoder.
#pragma once

#include <array>
#include <glm/vec4.hpp>
#include <vector>

#include "compress/light_map/basis/metric.h"
#include "compress/light_map/basis/model.h"
#include "compress/light_map/rows.h"

namespace lightcook::compress {

struct SampleTexel {
    int x, y;  ///< in the sample's images
    int cluster = 0;
    float weight = 0;              ///< of a squared error relative to coefficient 0
    std::array<float, 3> light{};  ///< [channel] squared decoded coefficient 0
    ByChannel ratio{};             ///< still to be coded, over the decoded coefficient 0
    std::size_t metric = 0;        ///< index of the sample's metrics
    glm::vec4 code{0.5f, 0.5f, 0.5f, 1};

    float totalLight() const { return light[0] + light[1] + light[2]; }
    float totalWeight() const { return weight * totalLight(); }
};

class BasisSample {
public:
    /// Encodes coefficient 0 of the samples (texture "l0"), and collects the covered texels as ratios to the decoded coefficient.
    /// plan, samples and options have to outlive the object.
    BasisSample(const LightMapPlan& plan, const LightMapSamples& samples, const EncodeOptions& options);
    BasisSample(const BasisSample&) = delete;
    BasisSample& operator=(const BasisSample&) = delete;

    std::vector<SampleTexel>& texels() { return texels_; }
    const std::vector<SampleTexel>& texels() const { return texels_; }
    /// The texels by cluster, each cluster in the order of texels(). One cluster before sortIntoClusters.
    const std::vector<std::vector<SampleTexel*>>& clusters() const { return clusters_; }
    /// Sorts the texels into `count` clusters by SampleTexel::cluster.
    void sortIntoClusters(int count);

    /// Block of the map that a texel comes from.
    int blockOf(const SampleTexel& texel) const;
    const Metric& metricOf(const SampleTexel& texel) const { return metrics_[texel.metric]; }
    BasisTarget targetOf(const SampleTexel& texel) const { return {texel.ratio, texel.light, &metricOf(texel)}; }

    /// Replaces the codes of all texels by the decoded ones of the block encoder, as texture plan.textures[texture].
    void encodeCodes(std::size_t texture, const glm::vec4& channelWeights);

private:
    void collect();
    void addSquareWeights();
    float blockWeight(const SampleTexel& texel) const;

    const LightMapPlan& plan_;
    const LightMapSamples& samples_;
    const EncodeOptions& options_;
    rows::Source source_;  ///< the blocks side by side, without their margins
    std::vector<SampleTexel> texels_;
    std::vector<Metric> metrics_;
    std::vector<std::vector<SampleTexel*>> clusters_;
};

/// Returns the coefficients of a texel over a decoded coefficient 0, clamped to +-4. If that is black: 1 for coefficient 0, 0 for the
/// others.
ByChannel ratiosTo(const rows::Source& source, int x, int y, const glm::vec3& decodedDc);

/// Returns the channel weights of an encoder from the growth of the error with each channel: 1 for the largest, 1e-3 at least.
glm::vec4 channelWeightsOf(const glm::dvec4& sensitivity);

}  // namespace lightcook::compress
