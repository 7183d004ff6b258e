#include "atlas/reduction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <optional>

#include "lighting/radiometry.h"

namespace lightcook::atlas {
namespace {

using formats::Image;
using lighting::ShRgb;

constexpr int kCoefficients = static_cast<int>(lighting::kShCount);
constexpr int kNormals = ReducedChart::kNormals;
/// Share of the samples of a chart that may exceed the limit.
constexpr double kShareBeyond = 0.01;
/// Steps of conjugate gradients. The matrix of bilinear weights has a condition of about 9, so that these reach rounding.
constexpr int kSteps = 16;
/// Weight of a texel's start value, relative to the mean diagonal: keeps texels that samples hardly reach near their neighbours.
constexpr double kRidge = 1e-3;
/// Longest band of a texel, relative to the longest of non-negative light with its sh00; readers of bakes refuse four times that length.
constexpr double kLongestBand = 2;

/// A place of the chart whose light is known.
struct Sample {
    glm::vec2 place{0};  ///< [texels of the bake] 0 is the centre of the chart's first texel
    ShRgb light{};
    std::array<glm::vec3, kNormals> normals{};
    std::array<glm::dvec3, kNormals> shown{};  ///< I, T and P
    double weight = 0;                         ///< of its squared error
};

/// The four texels of a grid around a place and their weights.
struct Footprint {
    std::array<std::size_t, 4> texels{};
    std::array<float, 4> weights{};
};

class Grid {
public:
    Grid(const glm::ivec2& texels, const glm::ivec2& step) : step_(step), size_((texels - 1 + step - 1) / step + 1) {}

    const glm::ivec2& size() const { return size_; }
    std::size_t count() const { return static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y); }
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.x) + static_cast<std::size_t>(x);
    }
    Footprint at(const glm::vec2& place) const {
        const glm::vec2 scaled = place / glm::vec2(step_);
        const glm::ivec2 low = glm::clamp(glm::ivec2(glm::floor(scaled)), glm::ivec2(0), glm::max(size_ - 2, 0));
        const glm::ivec2 high = glm::min(low + 1, size_ - 1);
        const glm::vec2 t = scaled - glm::vec2(low);
        return {{index(low.x, low.y), index(high.x, low.y), index(low.x, high.y), index(high.x, high.y)},
                {(1 - t.x) * (1 - t.y), t.x * (1 - t.y), (1 - t.x) * t.y, t.x * t.y}};
    }

private:
    glm::ivec2 step_, size_;
};

ShRgb interpolate(const std::vector<ShRgb>& texels, const Footprint& footprint) {
    ShRgb sum{};
    for (std::size_t corner = 0; corner < 4; ++corner)
        for (int i = 0; i < kCoefficients; ++i) sum[i] += footprint.weights[corner] * texels[footprint.texels[corner]][i];
    return sum;
}

/// Adds factor times light to the texels of a footprint, each by its weight.
void scatter(const ShRgb& light, float factor, const Footprint& footprint, std::vector<ShRgb>& texels) {
    for (std::size_t corner = 0; corner < 4; ++corner) {
        const float weight = factor * footprint.weights[corner];
        for (int i = 0; i < kCoefficients; ++i) texels[footprint.texels[corner]][i] += weight * light[i];
    }
}

using ShRgbDouble = std::array<glm::dvec3, lighting::kShCount>;

ShRgbDouble dot(const std::vector<ShRgb>& a, const std::vector<ShRgb>& b) {
    ShRgbDouble sum{};
    for (std::size_t texel = 0; texel < a.size(); ++texel)
        for (int i = 0; i < kCoefficients; ++i) sum[i] += glm::dvec3(a[texel][i]) * glm::dvec3(b[texel][i]);
    return sum;
}

/// Returns a / b by coefficient and channel; 0 where b is 0.
ShRgb ratio(const ShRgbDouble& a, const ShRgbDouble& b) {
    ShRgb quotient{};
    for (int i = 0; i < kCoefficients; ++i)
        for (int channel = 0; channel < 3; ++channel)
            quotient[i][channel] = b[i][channel] > 0 ? static_cast<float>(a[i][channel] / b[i][channel]) : 0.0f;
    return quotient;
}

/// The weighted least-squares problem of the samples over the texels of a grid. Its normal equations are solved by conjugate gradients with
/// the diagonal as preconditioner (Shewchuk 1994, An Introduction to the Conjugate Gradient Method Without the Agonizing Pain).
class LeastSquares {
public:
    LeastSquares(const std::vector<Sample>& samples, const Grid& grid) : samples_(samples), diagonal_(grid.count()) {
        footprints_.reserve(samples.size());
        for (const Sample& sample : samples) {
            footprints_.push_back(grid.at(sample.place));
            for (std::size_t corner = 0; corner < 4; ++corner) {
                const float weight = footprints_.back().weights[corner];
                diagonal_[footprints_.back().texels[corner]] += sample.weight * static_cast<double>(weight) * static_cast<double>(weight);
            }
        }
        double sum = 0, count = 0;
        for (const double each : diagonal_) {
            sum += each;
            count += each > 0 ? 1 : 0;
        }
        ridge_ = kRidge * sum / std::max(count, 1.0);
    }

    const Footprint& footprint(std::size_t sample) const { return footprints_[sample]; }
    /// True for texels that some sample reads.
    bool isKnown(std::size_t texel) const { return diagonal_[texel] > 0; }

    std::vector<ShRgb> solve(const std::atomic<bool>& interrupted) const {
        std::vector<ShRgb> texels = means();
        std::vector<ShRgb> residual(texels.size());  // the ridge pulls to the start, so it adds nothing here
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            ShRgb error = interpolate(texels, footprints_[i]);
            for (int k = 0; k < kCoefficients; ++k) error[k] = samples_[i].light[k] - error[k];
            scatter(error, static_cast<float>(samples_[i].weight), footprints_[i], residual);
        }
        std::vector<ShRgb> scaled = precondition(residual), direction = scaled;
        ShRgbDouble energy = dot(residual, scaled);
        for (int step = 0; step < kSteps && !interrupted; ++step) {
            const std::vector<ShRgb> image = apply(direction);
            const ShRgb length = ratio(energy, dot(direction, image));
            add(texels, length, direction, 1);
            add(residual, length, image, -1);
            scaled = precondition(residual);
            const ShRgbDouble next = dot(residual, scaled);
            const ShRgb turn = ratio(next, energy);
            for (std::size_t texel = 0; texel < direction.size(); ++texel)
                for (int k = 0; k < kCoefficients; ++k) direction[texel][k] = scaled[texel][k] + turn[k] * direction[texel][k];
            energy = next;
        }
        return texels;
    }

private:
    static void add(std::vector<ShRgb>& sum, const ShRgb& factor, const std::vector<ShRgb>& term, float sign) {
        for (std::size_t texel = 0; texel < sum.size(); ++texel)
            for (int k = 0; k < kCoefficients; ++k) sum[texel][k] += sign * factor[k] * term[texel][k];
    }
    /// Returns the mean of the samples around each texel, by their weights.
    std::vector<ShRgb> means() const {
        std::vector<ShRgb> sums(diagonal_.size());
        std::vector<float> weights(diagonal_.size());
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            scatter(samples_[i].light, static_cast<float>(samples_[i].weight), footprints_[i], sums);
            for (std::size_t corner = 0; corner < 4; ++corner)
                weights[footprints_[i].texels[corner]] += static_cast<float>(samples_[i].weight) * footprints_[i].weights[corner];
        }
        for (std::size_t texel = 0; texel < sums.size(); ++texel)
            if (weights[texel] > 0)
                for (glm::vec3& coefficient : sums[texel]) coefficient /= weights[texel];
        return sums;
    }
    std::vector<ShRgb> apply(const std::vector<ShRgb>& direction) const {
        std::vector<ShRgb> image(direction.size());
        for (std::size_t i = 0; i < samples_.size(); ++i)
            scatter(interpolate(direction, footprints_[i]), static_cast<float>(samples_[i].weight), footprints_[i], image);
        for (std::size_t texel = 0; texel < image.size(); ++texel)
            for (int k = 0; k < kCoefficients; ++k) image[texel][k] += static_cast<float>(ridge_) * direction[texel][k];
        return image;
    }
    std::vector<ShRgb> precondition(const std::vector<ShRgb>& residual) const {
        std::vector<ShRgb> scaled = residual;
        for (std::size_t texel = 0; texel < scaled.size(); ++texel)
            for (glm::vec3& coefficient : scaled[texel]) coefficient /= static_cast<float>(diagonal_[texel] + ridge_);
        return scaled;
    }

    const std::vector<Sample>& samples_;
    std::vector<Footprint> footprints_;
    std::vector<double> diagonal_;  ///< of the normal equations, without the ridge
    double ridge_ = 0;
};

/// Clamps coefficients that no light can have: sh00 to at least 0, and bands to kLongestBand.
void clampToLight(std::vector<ShRgb>& texels) {
    for (ShRgb& sh : texels)
        for (int channel = 0; channel < 3; ++channel) {
            sh[0][channel] = std::max(sh[0][channel], 0.0f);
            for (const std::size_t degree : {1u, 2u}) {
                double squares = 0;
                for (std::size_t i = degree * degree; i < (degree + 1) * (degree + 1); ++i)
                    squares += static_cast<double>(sh[i][channel]) * static_cast<double>(sh[i][channel]);
                const double longest = kLongestBand * std::sqrt(2 * static_cast<double>(degree) + 1) * static_cast<double>(sh[0][channel]);
                if (squares <= longest * longest) continue;
                for (std::size_t i = degree * degree; i < (degree + 1) * (degree + 1); ++i)
                    sh[i][channel] *= static_cast<float>(longest / std::sqrt(squares));
            }
        }
}

/// Returns a normal and four that lie 45 degrees from it.
std::array<glm::vec3, kNormals> normalsAround(const glm::vec3& normal) {
    const glm::vec3 other = std::abs(normal.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    const glm::vec3 tangent = glm::normalize(glm::cross(normal, other)), bitangent = glm::cross(normal, tangent);
    const float part = std::sqrt(0.5f);
    return {normal, part * (normal + tangent), part * (normal - tangent), part * (normal + bitangent), part * (normal - bitangent)};
}

class Reducer {
public:
    Reducer(const Chart& chart, const MapView& map, const ReductionLimit& limit, const std::atomic<bool>& interrupted)
        : chart_(chart), map_(map), limit_(limit), interrupted_(interrupted) {
        takeSamples();
    }

    ReducedChart reduce() const {
        const std::optional<Candidate> best = coarsest();
        ReducedChart made = best ? reduced(*best) : whole();
        made.readBefore = countOfRead();
        return made;
    }

private:
    struct Candidate {
        glm::ivec2 step{1};
        std::vector<ShRgb> texels = {};
        std::vector<bool> known = {};
        std::vector<float> visible = {};
        double squaredVisible = 0, squaredError = 0, squaredLight = 0;
    };

    /// Returns the candidate at which no axis can be halved any more; nothing if the chart keeps its resolution.
    std::optional<Candidate> coarsest() const {
        std::optional<Candidate> best;
        if (!(limit_.maxVisible > 0) || samples_.empty()) return best;
        std::array<bool, 2> mayGrow = {true, true};
        while (!interrupted_) {
            const glm::ivec2 step = best ? best->step : glm::ivec2(1);
            std::optional<Candidate> next;
            for (int axis = 0; axis < 2; ++axis) {
                if (!mayGrow[static_cast<std::size_t>(axis)] || step[axis] >= chart_.texels()[axis] - 1) continue;
                glm::ivec2 longer = step;
                longer[axis] *= 2;
                std::optional<Candidate> tried = candidate(longer);
                if (!tried)
                    mayGrow[static_cast<std::size_t>(axis)] = false;
                else if (!next || tried->squaredVisible < next->squaredVisible)
                    next = std::move(tried);
            }
            if (!next) break;
            best = std::move(next);
        }
        return best;
    }

    /// Returns the texel of the map that a sampler reads for a texel of the chart.
    glm::ivec2 source(int x, int y) const {
        return glm::clamp(chart_.first + glm::ivec2(x, y), glm::ivec2(0), glm::ivec2(map_.sh.width, map_.sh.height) - 1);
    }
    bool isCovered(int x, int y) const {
        const glm::ivec2 at = source(x, y);
        return map_.covered.at(at.x, at.y) != 0;
    }

    void takeSamples() {
        const glm::ivec2 texels = chart_.texels();
        Image<std::uint8_t> isRead(texels.x, texels.y, 0);
        for (int y = 0; y < chart_.quads.y; ++y)
            for (int x = 0; x < chart_.quads.x; ++x) {
                if (!chart_.reaches(x, y)) continue;
                int covered = 0;
                Sample middle{.place = glm::vec2(x, y) + 0.5f};
                glm::vec3 normal(0);
                for (const glm::ivec2 corner : {glm::ivec2(0, 0), glm::ivec2(1, 0), glm::ivec2(0, 1), glm::ivec2(1, 1)}) {
                    isRead.at(x + corner.x, y + corner.y) = 1;
                    if (!isCovered(x + corner.x, y + corner.y)) continue;
                    const glm::ivec2 at = source(x + corner.x, y + corner.y);
                    ++covered;
                    normal += map_.normal.at(at.x, at.y);
                    for (int i = 0; i < kCoefficients; ++i) middle.light[i] += map_.sh.at(at.x, at.y)[i];
                }
                if (covered == 0 || covered == 4) continue;
                for (glm::vec3& coefficient : middle.light) coefficient /= static_cast<float>(covered);
                addSample(middle, normal);
            }
        for (int y = 0; y < texels.y; ++y)
            for (int x = 0; x < texels.x; ++x) {
                if (isRead.at(x, y) == 0 || !isCovered(x, y)) continue;
                const glm::ivec2 at = source(x, y);
                addSample({.place = glm::vec2(x, y), .light = map_.sh.at(at.x, at.y)}, map_.normal.at(at.x, at.y));
            }
    }

    void addSample(Sample sample, const glm::vec3& normal) {
        const float length = glm::length(normal);
        sample.normals = normalsAround(length > 0 ? normal / length : glm::vec3(0, 0, 1));
        const ShRgb exit = lighting::convolve(sample.light, lighting::kExitRadianceBands);
        for (std::size_t i = 0; i < sample.normals.size(); ++i)
            sample.shown[i] = shown(glm::dvec3(lighting::evaluate(exit, sample.normals[i])));
        const double luminance =
            std::max(0.0, static_cast<double>(glm::dot(lighting::evaluate(exit, sample.normals[0]), limit_.luminanceWeights)));
        const double nits = luminance * limit_.display.nitsPerUnit + limit_.display.black;
        sample.weight = 1 / (nits * nits);
        samples_.push_back(sample);
    }

    glm::dvec3 shown(const glm::dvec3& light) const {
        return lighting::kVisibleScale *
               lighting::ictcpItp(limit_.bt2020FromWorking * (glm::max(light, 0.0) * limit_.display.nitsPerUnit + limit_.display.black));
    }

    /// Returns the chart at a step; nothing if its error is over the limit.
    std::optional<Candidate> candidate(const glm::ivec2& step) const {
        const Grid grid(chart_.texels(), step);
        const LeastSquares system(samples_, grid);
        Candidate made{.step = step, .texels = system.solve(interrupted_)};
        clampToLight(made.texels);
        const auto allowed = static_cast<std::int64_t>(kShareBeyond * static_cast<double>(samples_.size() * kNormals));
        std::int64_t beyond = 0;
        made.visible.reserve(samples_.size() * kNormals);
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            const Sample& sample = samples_[i];
            const ShRgb light = interpolate(made.texels, system.footprint(i));
            const ShRgb exit = lighting::convolve(light, lighting::kExitRadianceBands),
                        reference = lighting::convolve(sample.light, lighting::kExitRadianceBands);
            for (std::size_t k = 0; k < sample.normals.size(); ++k) {
                const glm::dvec3 found(lighting::evaluate(exit, sample.normals[k])),
                    wanted(lighting::evaluate(reference, sample.normals[k]));
                const double visible = glm::distance(shown(found), sample.shown[k]);
                made.visible.push_back(static_cast<float>(visible));
                made.squaredVisible += visible * visible;
                made.squaredError += glm::dot(found - wanted, found - wanted);
                made.squaredLight += glm::dot(wanted, wanted);
                beyond += visible > limit_.maxVisible ? 1 : 0;
            }
            if (beyond > allowed) return std::nullopt;
        }
        const double relRms = ReductionLimit::kRelRmsPerVisible * limit_.maxVisible;
        if (made.squaredError > relRms * relRms * made.squaredLight) return std::nullopt;
        for (std::size_t texel = 0; texel < grid.count(); ++texel) made.known.push_back(system.isKnown(texel));
        return made;
    }

    /// Marks the texels of a grid that filters read.
    Image<std::uint8_t> readTexels(const Grid& grid, const glm::ivec2& step) const {
        Image<std::uint8_t> isRead(grid.size().x, grid.size().y, 0);
        for (int y = 0; y < chart_.quads.y; ++y)
            for (int x = 0; x < chart_.quads.x; ++x)
                if (chart_.reaches(x, y))
                    for (int corner = 0; corner < 4; ++corner)
                        isRead.at(std::min(x / step.x + corner % 2, grid.size().x - 1),
                                  std::min(y / step.y + corner / 2, grid.size().y - 1)) = 1;
        return isRead;
    }

    /// Returns the number of texels of the map that filters read. A filter at the border of the map reads a texel of it twice.
    std::int64_t countOfRead() const {
        const Image<std::uint8_t> read = readTexels(Grid(chart_.texels(), glm::ivec2(1)), glm::ivec2(1));
        std::int64_t count = 0;
        for (int y = 0; y < read.height(); ++y)
            for (int x = 0; x < read.width(); ++x) count += read.at(x, y) != 0 && source(x, y) == chart_.first + glm::ivec2(x, y) ? 1 : 0;
        return count;
    }

    /// Returns the chart as the bake has it.
    ReducedChart whole() const {
        const glm::ivec2 size = chart_.texels();
        ReducedChart made{.step = glm::ivec2(1),
                          .sh = Image<ShRgb>(size.x, size.y),
                          .covered = Image<std::uint8_t>(size.x, size.y, 0),
                          .normal = Image<glm::vec3>(size.x, size.y, glm::vec3(0, 0, 1)),
                          .isRead = readTexels(Grid(size, glm::ivec2(1)), glm::ivec2(1)),
                          .visible = std::vector<float>(samples_.size() * kNormals, 0.0f)};
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const glm::ivec2 at = source(x, y);
                made.sh.at(x, y) = map_.sh.at(at.x, at.y);
                made.covered.at(x, y) = map_.covered.at(at.x, at.y);
                made.normal.at(x, y) = map_.normal.at(at.x, at.y);
            }
        for (const Sample& sample : samples_) {
            const ShRgb exit = lighting::convolve(sample.light, lighting::kExitRadianceBands);
            for (const glm::vec3& normal : sample.normals) {
                const glm::dvec3 light(lighting::evaluate(exit, normal));
                made.squaredLight += glm::dot(light, light);
            }
        }
        return made;
    }

    ReducedChart reduced(const Candidate& candidate) const {
        const Grid grid(chart_.texels(), candidate.step);
        const glm::ivec2 size = grid.size();
        ReducedChart made{.step = candidate.step,
                          .sh = Image<ShRgb>(size.x, size.y),
                          .covered = Image<std::uint8_t>(size.x, size.y, 0),
                          .normal = Image<glm::vec3>(size.x, size.y, glm::vec3(0)),
                          .isRead = readTexels(grid, candidate.step),
                          .visible = candidate.visible,
                          .squaredError = candidate.squaredError,
                          .squaredLight = candidate.squaredLight};
        for (const Sample& sample : samples_) {
            const Footprint footprint = grid.at(sample.place);
            for (std::size_t corner = 0; corner < 4; ++corner)
                made.normal.texels()[footprint.texels[corner]] += footprint.weights[corner] * sample.normals[0];
        }
        for (std::size_t texel = 0; texel < grid.count(); ++texel) {
            glm::vec3& normal = made.normal.texels()[texel];
            const float length = glm::length(normal);
            made.covered.texels()[texel] = candidate.known[texel] && length > 0 ? 1 : 0;
            normal = length > 0 ? normal / length : glm::vec3(0, 0, 1);
            if (made.covered.texels()[texel] != 0) made.sh.texels()[texel] = candidate.texels[texel];
        }
        return made;
    }

    const Chart& chart_;
    const MapView& map_;
    const ReductionLimit& limit_;
    const std::atomic<bool>& interrupted_;
    std::vector<Sample> samples_;
};

}  // namespace

ReducedChart reduceChart(const Chart& chart, const MapView& map, const ReductionLimit& limit, const std::atomic<bool>& interrupted) {
    return Reducer(chart, map, limit, interrupted).reduce();
}

}  // namespace lightcook::atlas
