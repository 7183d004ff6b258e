// Family rnm: the light of three directions in the tangent frame of each texel, in the units of the engine. Every texel's light is the one
// that shows the bake best over the normals of a normal map (rnm_fit.h). The textures are encoded one after the other; those that are left
// are solved again for the decoded ones, so that an error does not enter twice.
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <span>

#include "compress/light_map/families.h"
#include "compress/light_map/rnm_fit.h"

namespace lightcook::compress::rows {

namespace {

using formats::Image;

constexpr std::size_t kDirections = 3;

class RnmRows {
public:
    RnmRows(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source, const EncodeOptions& options)
        : plan_(plan), strip_(strip), source_(source), options_(options) {}

    EncodedLightMapRows run() {
        out_.textures.resize(kDirections);
        for (std::size_t i = 0; i < kDirections; ++i) {
            Image<glm::vec3> values(source_.width, source_.height, glm::vec3(0));
            forEachPadded(source_, [&](int x, int y) { values.at(x, y) = lightAt(x, y)[i]; });
            Layer layer = encodeHdr(plan_, source_, values, 1, options_, i + 1 < kDirections, out_.report);
            out_.textures[i].layers.push_back(std::move(layer.bytes));
            if (i + 1 < kDirections) decoded_.push_back(std::move(layer.decoded));
        }
        return std::move(out_);
    }

private:
    /// Returns the best light of the directions for the decoded ones.
    std::array<glm::vec3, kDirections> lightAt(int x, int y) const {
        const std::array<lighting::ShDouble, 3> local = inTangents(x, y);
        std::array<glm::vec3, kDirections> light{};
        for (int c = 0; c < 3; ++c) {
            std::array<double, kDirections> known{};
            for (std::size_t i = 0; i < decoded_.size(); ++i) known[i] = static_cast<double>(decoded_[i].at(x, y)[c]);
            const glm::dvec3 best = RnmFit(local[static_cast<std::size_t>(c)]).best(std::span(known).first(decoded_.size()));
            for (std::size_t i = 0; i < kDirections; ++i) light[i][c] = static_cast<float>(best[static_cast<int>(i)]);
        }
        return light;
    }
    /// Returns the coefficients of a texel by channel, in the tangent frame of its owner.
    std::array<lighting::ShDouble, 3> inTangents(int x, int y) const {
        const glm::ivec2 owner = source_.owner.at(x, y);
        const glm::dvec3 normal(strip_.normal.at(owner.x, owner.y - strip_.firstRow));
        const glm::dvec4 stored(strip_.tangent.at(owner.x, owner.y - strip_.firstRow));
        const glm::dvec3 tangent(stored);
        const glm::dmat3 worldFromTangents(tangent, stored.w * glm::cross(normal, tangent), normal);
        const lighting::ShRotation rotation(glm::transpose(worldFromTangents));
        const auto light = source_.lightAt(x, y, 1);
        std::array<lighting::ShDouble, 3> local{};
        for (int c = 0; c < 3; ++c) {
            lighting::ShDouble channel{};
            for (std::size_t i = 0; i < channel.size(); ++i) channel[i] = static_cast<double>(light[i][c]);
            local[static_cast<std::size_t>(c)] = rotation.apply(channel);
        }
        return local;
    }

    const LightMapPlan& plan_;
    const formats::LightMapStrip& strip_;
    const Source& source_;
    const EncodeOptions& options_;
    std::vector<Image<glm::vec4>> decoded_;  ///< of the first directions
    EncodedLightMapRows out_;
};

}  // namespace

EncodedLightMapRows encodeRnm(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source,
                              const EncodeOptions& options) {
    return RnmRows(plan, strip, source, options).run();
}

}  // namespace lightcook::compress::rows
