// The sample that a learned layout is fitted to: the covered texels of the chosen blocks, and the stages that they have passed. Private to
// compress/.
//
// Each stage subtracts from `ratio` what its decoded texels give, so that the next one is fitted to the real error of the encoder.
#pragma once

#include <array>
#include <glm/vec4.hpp>
#include <vector>

#include "compress/light_map/basis/model.h"
#include "compress/light_map/rows.h"

namespace lightcook::compress {

struct SampleTexel {
    int x, y;  ///< in the sample's images
    int cluster = 0;
    float weight = 0;                                   ///< of the cost
    std::array<glm::vec3, lighting::kShCount> light{};  ///< of the reference, over the range of texture "l0"
    PackedForm form{};                                  ///< cost of an error of the light
    glm::vec3 dc{0};                                    ///< coefficient 0 as it is stored, over the same
    ByChannel ratio{};                                  ///< still to be coded, over the stored coefficient 0
    std::array<float, 3> channelWeights{};              ///< RatioCost::channelWeights
    glm::vec4 code{0.5f, 0.5f, 0.5f, 1};

    float totalCost() const { return channelWeights[0] + channelWeights[1] + channelWeights[2]; }
    float totalWeight() const { return weight * totalCost(); }
};

class BasisSample {
public:
    /// Collects the covered texels as ratios to their own coefficient 0.
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

    /// Mean square of coefficient 0, over the range of texture "l0".
    double lightSquare() const { return lightSquare_; }
    /// Block of the map that a texel comes from.
    int blockOf(const SampleTexel& texel) const;
    static BasisTarget targetOf(const SampleTexel& texel) { return {texel.ratio, RatioCost(texel.form.unpacked(), texel.dc)}; }

    /// Sets the coefficient 0 of a texel, and its ratios to it.
    static void setDc(SampleTexel& texel, const glm::vec3& dc);
    /// Replaces the coefficients 0 of all texels by the decoded ones of the block encoder (texture "l0").
    void encodeDc();
    /// Replaces the codes of all texels by the decoded ones of the block encoder, as texture plan.textures[texture].
    void encodeCodes(std::size_t texture, const glm::vec4& channelWeights);

private:
    double measureLight() const;
    void collect();
    void measureForms(const ShadingForm& shading);
    void addSquareWeights(double share);
    /// x  in the sample's images
    float blockWeight(int x) const;

    const LightMapPlan& plan_;
    const LightMapSamples& samples_;
    const EncodeOptions& options_;
    double lightSquare_ = 0;
    rows::Source source_;  ///< the blocks side by side, without their margins
    std::vector<SampleTexel> texels_;
    std::vector<std::vector<SampleTexel*>> clusters_;
};

/// Returns the coefficients of a texel over a stored coefficient 0, clamped to +-4. If that is black: 1 for coefficient 0, 0 for the
/// others.
ByChannel ratiosTo(std::span<const glm::vec3> light, const glm::vec3& dc);

/// Returns the channel weights of an encoder from the growth of the error with each channel: 1 for the largest, 1e-3 at least.
glm::vec4 channelWeightsOf(const glm::dvec4& sensitivity);

}  // namespace lightcook::compress
