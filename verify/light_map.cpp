#include "verify/light_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>

#include "lighting/radiometry.h"
#include "verify/light_map_bound.h"
#include "verify/light_map_layouts.h"
#include "verify/light_map_shading.h"

namespace verify {

namespace {

using layouts::Texels;
using shaders::LcSh;

constexpr std::size_t kChannels = 3, kCount = lighting::kShCount;
/// product.md: local errors are relative to |reference| + 0.02 key. All light here is in units of the key.
constexpr double kFloor = 0.02;
constexpr double kLogUnits = 1 << 24;
/// The control vectors come from float evaluations of the decode: conversion to Bernstein form magnifies their rounding by at most 6 an
/// axis.
constexpr double kRounding = 2e-5;
/// What float sums of nine products may add to a sampled error, as a part of it.
constexpr double kShadingRounding = 2e-6;

using Channel = lighting::Sh;
using Channels = std::array<Channel, kChannels>;

LcSh difference(const LcSh& a, const LcSh& b) {
    LcSh out;
    for (std::size_t i = 0; i < kCount; ++i) out.c[i] = a.c[i] - b.c[i];
    return out;
}

LcSh scaled(const LcSh& sh, float factor) {
    LcSh out;
    for (std::size_t i = 0; i < kCount; ++i) out.c[i] = factor * sh.c[i];
    return out;
}

LcSh blend(const LcSh& a, const LcSh& b, float weight) {
    LcSh out;
    for (std::size_t i = 0; i < kCount; ++i) out.c[i] = (1 - weight) * a.c[i] + weight * b.c[i];
    return out;
}

template <std::size_t kLayers>
std::array<glm::vec4, kLayers> blend(const std::array<glm::vec4, kLayers>& a, const std::array<glm::vec4, kLayers>& b, float weight) {
    std::array<glm::vec4, kLayers> out;
    for (std::size_t i = 0; i < kLayers; ++i) out[i] = (1 - weight) * a[i] + weight * b[i];
    return out;
}

/// A random number in [0, 1) that is a function of its place alone.
float hashedFraction(std::uint64_t seed, std::uint64_t place) {
    std::uint64_t z = seed * 0x9e3779b97f4a7c15u + place * 0xbf58476d1ce4e5b9u + 0x94d049bb133111ebu;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<float>((z ^ (z >> 31)) >> 40) * 0x1p-24f;
}

/// Control values of the polynomial of degree kDegree that takes these values at i / kDegree, i = 0 .. kDegree.
template <int kDegree>
void bernsteinFromNodes(std::array<LcSh*, kDegree + 1> nodes) {
    for (std::size_t i = 0; i < kCount; ++i) {
        if constexpr (kDegree == 2) {
            nodes[1]->c[i] = 2.0f * nodes[1]->c[i] - 0.5f * (nodes[0]->c[i] + nodes[2]->c[i]);
        } else if constexpr (kDegree == 3) {
            const glm::vec3 p0 = nodes[0]->c[i], p1 = nodes[1]->c[i], p2 = nodes[2]->c[i], p3 = nodes[3]->c[i];
            nodes[1]->c[i] = (-5.0f * p0 + 18.0f * p1 - 9.0f * p2 + 2.0f * p3) / 6.0f;
            nodes[2]->c[i] = (2.0f * p0 - 9.0f * p1 + 18.0f * p2 - 5.0f * p3) / 6.0f;
        }
    }
}

/// Largest proven errors so far. What cannot exceed them by a cheap bound is not looked at more closely: the maximum stays exact.
struct Worst {
    double diffuse = 0, specular = 0;
};

}  // namespace

void LightMapKey::add(const formats::LightMapBand& band, int firstRow, int rowCount) {
    assert(firstRow >= band.firstRow && firstRow + rowCount <= band.firstRow + band.sh.height());
    for (int y = firstRow - band.firstRow; y < firstRow - band.firstRow + rowCount; ++y)
        for (int x = 0; x < band.sh.width(); ++x) {
            if (band.covered.at(x, y) == 0) continue;
            const lighting::ShRgb exit = lighting::convolve(band.sh.at(x, y), lighting::kExitRadianceBands);
            const float luminance = glm::dot(lighting::evaluate(exit, band.normal.at(x, y)), luminanceWeights_);
            logLuminanceSum_ += std::llround(std::log(std::max(static_cast<double>(luminance), 1e-12)) * kLogUnits);
            ++coveredTexels_;
        }
}

void LightMapKey::merge(const LightMapKey& other) {
    logLuminanceSum_ += other.logLuminanceSum_;
    coveredTexels_ += other.coveredTexels_;
}

double LightMapKey::key() const {
    return coveredTexels_ == 0 ? 0 : std::exp(static_cast<double>(logLuminanceSum_) / kLogUnits / static_cast<double>(coveredTexels_));
}

void LightMapErrors::merge(const LightMapErrors& other) {
    if (accumulators.empty()) {
        accumulators = other.accumulators;
        return;
    }
    assert(accumulators.size() == other.accumulators.size());
    for (std::size_t i = 0; i < accumulators.size(); ++i) {
        accumulators[i].diffuse.merge(other.accumulators[i].diffuse);
        accumulators[i].specular.merge(other.accumulators[i].specular);
    }
}

std::vector<StageError> LightMapErrors::stages() const {
    std::vector<StageError> out;
    for (const Stage& stage : accumulators) out.push_back({stage.name, stage.diffuse.figures(), stage.specular.figures(), 0});
    if (out.size() < 2) return out;
    // The verdict: the last stage at texel centres, and whatever is worse between them.
    StageError total = out[out.size() - 2];
    const StageError& magnified = out.back();
    const auto worsen = [](ErrorFigures& figures, const ErrorFigures& other) {
        figures.maxSampled = std::max(figures.maxSampled, other.maxSampled);
        figures.maxBound = std::max(figures.maxBound, other.maxBound);
    };
    worsen(total.diffuse, magnified.diffuse);
    worsen(total.specular, magnified.specular);
    total.name = "total";
    out.push_back(total);
    return out;
}

struct LightMapVerifier::State {
    CookedLightMap map;
    LightMapShading shading;
    LightMapSampling sampling;
    float perKey = 1;  ///< light in units of the key
    layouts::Layout layout;
    std::vector<TextureNeed> textures;
    ShadingMatrix diffuse, specular;
    lighting::ShBands specularSuprema{};

    bool isFlat() const { return std::holds_alternative<layouts::Flat>(layout); }
    bool hasSpecular() const { return specular.count() > 0; }
};

namespace {

/// One run over rows of a map whose layout is known at compile time.
template <class Layout>
class RowVerifier {
public:
    RowVerifier(const Layout& layout, const LightMapVerifier& verifier, const CookedLightMap& map, const LightMapSampling& sampling,
                const ShadingMatrix& diffuse, const ShadingMatrix& specular, const lighting::ShBands& specularSuprema, float perKey,
                const DecodedLightMapRows& texels, const formats::LightMapBand& reference)
        : layout_(layout),
          map_(map),
          sampling_(sampling),
          specular_(specular),
          specularSuprema_(specularSuprema),
          perKey_(perKey),
          texels_(texels),
          reference_(reference),
          errors_(verifier.noErrors()),
          worst_(errors_.accumulators.size()),
          shader_(diffuse, specular) {}

    LightMapErrors run(int firstRow, int rowCount) {
        Row current, below;
        loadRow(firstRow, current);
        for (int y = firstRow; y < firstRow + rowCount; ++y) {
            for (int x = 0; x < map_.width; ++x)
                if (current.covered[index(x)] != 0) centre(current, x, y);
            if (!sampling_.bounds) {
                if (y + 1 < firstRow + rowCount) loadRow(y + 1, current);
                continue;
            }
            if (y + 1 >= map_.height) break;
            loadRow(y + 1, below);
            for (int x = 0; x + 1 < map_.width; ++x)
                if (current.covered[index(x)] != 0 && current.covered[index(x + 1)] != 0 && below.covered[index(x)] != 0 &&
                    below.covered[index(x + 1)] != 0)
                    quad(current, below, x, y);
            std::swap(current, below);
        }
        for (std::size_t stage = 0; stage < worst_.size(); ++stage) {
            errors_.accumulators[stage].diffuse.addBound(worst_[stage].diffuse);
            if (specular_.count() > 0) errors_.accumulators[stage].specular.addBound(worst_[stage].specular);
        }
        return std::move(errors_);
    }

private:
    using LayerTexels = Texels<Layout::kLayers>;
    static constexpr int kNodes = Layout::kDegree + 1;
    static constexpr std::size_t kControls = static_cast<std::size_t>(kNodes) * kNodes;
    using Controls = std::array<LcSh, kControls>;
    static std::size_t index(int x) { return static_cast<std::size_t>(x); }

    /// A row of the map as this pass needs it; light in units of the key.
    struct Row {
        std::vector<std::uint8_t> covered;
        std::vector<LcSh> reference;
        std::vector<LayerTexels> texels;
    };

    void loadRow(int y, Row& row) const {
        const auto width = index(map_.width);
        row.covered.resize(width);
        row.reference.resize(width);
        row.texels.resize(width);
        const int bandRow = y - reference_.firstRow, texelRow = y - texels_.firstRow;
        for (int x = 0; x < map_.width; ++x) {
            row.covered[index(x)] = reference_.covered.at(x, bandRow);
            if (row.covered[index(x)] == 0) continue;
            row.reference[index(x)] = referenceAt(x, bandRow);
            std::size_t layer = 0;
            for (const auto& texture : texels_.textures)
                for (const formats::Image<glm::vec4>& image : texture) row.texels[index(x)][layer++] = image.at(x, texelRow);
        }
    }

    LcSh referenceAt(int x, int bandRow) const {
        LcSh out{};
        const lighting::ShRgb& sh = reference_.sh.at(x, bandRow);
        for (std::size_t i = 0; i < kCount; ++i) out.c[i] = perKey_ * sh[i];
        if constexpr (std::is_same_v<Layout, layouts::Flat>) {
            LcSh flat{};
            flat.c[0] = shaders::lcExitRadiance(out, reference_.normal.at(x, bandRow)) / layouts::Flat::kY0;
            return flat;
        }
        return out;
    }

    /// The decode of texel (x, y) in units of the key.
    LcSh decoded(const LayerTexels& texels, int x, int y) const { return scaled(layouts::decodeAt(layout_, x, y).decode(texels), perKey_); }

    void setReference(const LcSh& reference, int x, int y) {
        shader_.setReference(reference, reference_.normal.at(x, y - reference_.firstRow));
    }
    void addErrors(std::size_t stage, const LcSh& error) {
        LightMapErrors::Stage& accumulators = errors_.accumulators[stage];
        shader_.add(error, accumulators.diffuse, accumulators.specular);
    }

    void centre(const Row& row, int x, int y) {
        const LcSh& reference = row.reference[index(x)];
        setReference(reference, x, y);
        std::size_t stage = 0;
        const auto stageError = [&](const LcSh& result) {
            const LcSh error = difference(result, reference);
            addErrors(stage, error);
            if (sampling_.bounds) boundCentre(stage, error, reference);
            ++stage;
        };
        if constexpr (Layout::kEarlyStages.size() > 0) {
            const LcSh unscaledReference = scaled(reference, 1 / perKey_);
            const auto& decode = layouts::decodeAt(layout_, x, y);
            for (std::size_t early = 0; early < Layout::kEarlyStages.size(); ++early)
                stageError(scaled(decode.decodeEarly(early, row.texels[index(x)], unscaledReference), perKey_));
        }
        stageError(decoded(row.texels[index(x)], x, y));
    }

    void boundCentre(std::size_t stage, const LcSh& error, const LcSh& reference) {
        if (isCertainlyWithin(worst_[stage], {&error, 1}, kShadingRounding, {})) return;
        const Channels errors = channelsOf(error), references = channelsOf(reference);
        for (std::size_t c = 0; c < kChannels; ++c) {
            const std::array<ErrorPair, 1> pair = {ErrorPair{errors[c], references[c]}};
            raise(worst_[stage], pair, kShadingRounding * bandSum(bandNorms(pair[0].error), kExitNorm));
        }
    }

    /// Takes the pairs of one channel into the worst so far.
    void raise(Worst& worst, std::span<const ErrorPair> pairs, double rounding) const {
        if (specular_.count() > 0)
            for (const ErrorPair& pair : pairs)
                worst.specular = std::max(worst.specular, (bandSum(bandNorms(pair.error), specularSuprema_) + 4 * rounding) / kFloor);
        if (!staysWithin(pairs, kFloor, rounding, worst.diffuse))
            worst.diffuse = std::max(worst.diffuse, localErrorBound(pairs, kFloor, rounding));
    }

    void quad(const Row& above, const Row& below, int x, int y) {
        const std::size_t i = index(x);
        const std::array<const LayerTexels*, 4> texels = {&above.texels[i], &above.texels[i + 1], &below.texels[i], &below.texels[i + 1]};
        const std::array<const LcSh*, 4> references = {&above.reference[i], &above.reference[i + 1], &below.reference[i],
                                                       &below.reference[i + 1]};
        for (int sample = 0; sample < sampling_.positionsPerQuad; ++sample) magnified(texels, references, x, y, sample);
        if constexpr (layouts::Zonal<Layout>) {
            boundZonal(texels, references, {}, 0);
        } else {
            Controls errors, filtered;
            for (int corner = 0; corner < 4; ++corner) {
                if (!isNewDecode(x, y, corner)) continue;
                const auto error = [&](const LayerTexels& t, const LcSh& reference) {
                    return difference(decoded(t, x + corner % 2, y + corner / 2), reference);
                };
                evaluateControls(texels, references, {}, error, errors, filtered);
                if (!isCertainlyWithin(worst_.back(), errors, kRounding, filtered)) boundQuad(pairsOf(errors, filtered), {});
            }
        }
    }
    /// Whether no corner before this one has the same decode: a quad is bounded under each that a surface could bring along.
    bool isNewDecode(int x, int y, int corner) const {
        if constexpr (requires { layout_.at(x, y); }) {
            const auto at = [&](int i) { return layout_.at(x + i % 2, y + i / 2); };
            for (int before = 0; before < corner; ++before)
                if (at(before) == at(corner)) return false;
            return true;
        }
        return corner == 0;
    }

    /// The four corners as the filter sees them at (u, v).
    struct Filtered {
        LayerTexels texels;
        LcSh reference;
    };
    static Filtered filter(const std::array<const LayerTexels*, 4>& texels, const std::array<const LcSh*, 4>& references, float u,
                           float v) {
        return {blend(blend(*texels[0], *texels[1], u), blend(*texels[2], *texels[3], u), v),
                blend(blend(*references[0], *references[1], u), blend(*references[2], *references[3], u), v)};
    }

    void magnified(const std::array<const LayerTexels*, 4>& texels, const std::array<const LcSh*, 4>& references, int x, int y,
                   int sample) {
        const auto place = 2 * ((static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(map_.width) + static_cast<std::uint64_t>(x)) *
                                    static_cast<std::uint64_t>(sampling_.positionsPerQuad) +
                                static_cast<std::uint64_t>(sample));
        const Filtered at = filter(texels, references, hashedFraction(sampling_.seed, place), hashedFraction(sampling_.seed, place + 1));
        setReference(at.reference, x, y);
        addErrors(worst_.size() - 1, difference(decoded(at.texels, x, y), at.reference));
    }

    /// A square part of a quad.
    struct Part {
        float u = 0, v = 0, size = 1;
    };
    /// value(filtered texels, filtered reference) at the (degree + 1)^2 nodes of a part of the quad, turned into Bernstein control vectors:
    /// its value at every position is a mean of them. The filtered reference is bilinear: its form of the same degree has its values at the
    /// nodes themselves for controls.
    template <class Value>
    static void evaluateControls(const std::array<const LayerTexels*, 4>& texels, const std::array<const LcSh*, 4>& references,
                                 const Part& part, Value&& value, Controls& values, Controls& filtered) {
        for (int v = 0; v < kNodes; ++v) {
            const float fv = part.v + part.size * static_cast<float>(v) / Layout::kDegree;
            const LayerTexels left = blend(*texels[0], *texels[2], fv), right = blend(*texels[1], *texels[3], fv);
            const LcSh leftReference = blend(*references[0], *references[2], fv),
                       rightReference = blend(*references[1], *references[3], fv);
            for (int u = 0; u < kNodes; ++u) {
                const float fu = part.u + part.size * static_cast<float>(u) / Layout::kDegree;
                const auto node = static_cast<std::size_t>(v * kNodes + u);
                filtered[node] = blend(leftReference, rightReference, fu);
                values[node] = value(blend(left, right, fu), filtered[node]);
            }
        }
        if constexpr (Layout::kDegree > 1) {
            for (int line = 0; line < kNodes; ++line) convertLine(values, line * kNodes, 1);
            for (int line = 0; line < kNodes; ++line) convertLine(values, line, kNodes);
        }
    }
    static void convertLine(Controls& nodes, int first, int step) {
        std::array<LcSh*, static_cast<std::size_t>(kNodes)> line;
        for (int i = 0; i < kNodes; ++i) line[static_cast<std::size_t>(i)] = &nodes[static_cast<std::size_t>(first + i * step)];
        bernsteinFromNodes<Layout::kDegree>(line);
    }

    using Pairs = std::array<std::array<ErrorPair, kControls>, kChannels>;
    static Pairs pairsOf(const Controls& errors, const Controls& filtered) {
        Pairs pairs;
        for (std::size_t k = 0; k < kControls; ++k) {
            const Channels error = channelsOf(errors[k]), reference = channelsOf(filtered[k]);
            for (std::size_t c = 0; c < kChannels; ++c) pairs[c][k] = {error[c], reference[c]};
        }
        return pairs;
    }

    /// Largest of the pairs, as exit radiance.
    static double magnitudeOf(std::span<const ErrorPair> pairs) {
        double magnitude = 0;
        for (const ErrorPair& pair : pairs)
            magnitude = std::max(magnitude, bandSum(bandNorms(pair.error), kExitNorm) + bandSum(bandNorms(pair.reference), kExitNorm));
        return magnitude;
    }

    /// The largest squared norm of each band and channel among control vectors.
    static std::array<glm::vec3, 3> largestSquares(std::span<const LcSh> controls) {
        std::array<glm::vec3, 3> largest{};
        for (const LcSh& control : controls) {
            std::array<glm::vec3, 3> sums{};
            for (std::size_t i = 0; i < kCount; ++i) sums[static_cast<std::size_t>(lighting::kShBand[i])] += control.c[i] * control.c[i];
            for (std::size_t l = 0; l < 3; ++l) largest[l] = glm::max(largest[l], sums[l]);
        }
        return largest;
    }
    /// A cheap yes, for most texels and quads: the largest norms of each band together, whichever controls they come from, are under the
    /// worst so far. rounding: of errors and references, as a part of them.
    bool isCertainlyWithin(const Worst& worst, std::span<const LcSh> errors, double rounding, std::span<const LcSh> references) const {
        // Sums of squares of floats, a few units in the last place, and what squares lose under the smallest float.
        constexpr double kSlack = 1 + 1e-5, kTiny = 1e-18;
        const std::array<glm::vec3, 3> error = largestSquares(errors), reference = largestSquares(references);
        const auto norms = [&](const std::array<glm::vec3, 3>& squares, std::size_t channel) {
            lighting::ShBands out{};
            for (std::size_t l = 0; l < 3; ++l)
                out[l] = kSlack * std::sqrt(static_cast<double>(squares[l][static_cast<int>(channel)])) + kTiny;
            return out;
        };
        for (std::size_t c = 0; c < kChannels; ++c) {
            const lighting::ShBands own = norms(error, c);
            const double diffuse = bandSum(own, kExitNorm), missing = rounding * (diffuse + bandSum(norms(reference, c), kExitNorm));
            // Not "greater": what is not a number has to be looked at.
            if (!(diffuse + missing <= kFloor * worst.diffuse)) return false;
            if (specular_.count() > 0 && !(bandSum(own, specularSuprema_) + 4 * missing <= kFloor * worst.specular)) return false;
        }
        return true;
    }

    /// missing: what each channel's error may have beyond its pairs, as exit radiance.
    void boundQuad(const Pairs& pairs, const std::array<double, kChannels>& missing) {
        for (std::size_t c = 0; c < kChannels; ++c) raise(worst_.back(), pairs[c], kRounding * magnitudeOf(pairs[c]) + missing[c]);
    }

    /// A layout whose band 2 is z(p) Y(a(p)), z a polynomial and a(p) the axis of another, is bounded as the polynomial z(p) Y(a0) with one
    /// axis a0 for the part, and at most |z| |Y(a) - Y(a0)| beside it (axisCone). Where that is much of the error and could be the map's
    /// worst, the part is looked at in quarters: axes turn less in them.
    void boundZonal(const std::array<const LayerTexels*, 4>& texels, const std::array<const LcSh*, 4>& references, const Part& part,
                    int depth) {
        Controls bands, filtered;
        // The vector of the axis lies in c[5], beside the zonal coefficient in c[4]: both are polynomials as well.
        const auto value = [&](const LayerTexels& t, const LcSh&) {
            LcSh sh = scaled(layout_.bands(t), perKey_);
            const glm::vec3& weights = layout_.k.luminance;
            sh.c[5] = {glm::dot(weights, sh.c[3]), glm::dot(weights, sh.c[1]), glm::dot(weights, sh.c[2])};
            return sh;
        };
        evaluateControls(texels, references, part, value, bands, filtered);
        const AxisCone cone = coneOf(bands);
        std::array<double, kChannels> missing{};
        for (LcSh& sh : bands)
            for (std::size_t c = 0; c < kChannels; ++c)
                missing[c] =
                    std::max(missing[c], kExitNorm[2] * cone.deviation * static_cast<double>(std::abs(sh.c[4][static_cast<int>(c)])));
        for (std::size_t k = 0; k < kControls; ++k) bands[k] = difference(shaders::lcZonalBand2(bands[k], cone.axis), filtered[k]);
        const Pairs pairs = pairsOf(bands, filtered);
        if (depth < kZonalDepth && isWorthSplitting(pairs, missing)) {
            const float half = 0.5f * part.size;
            for (const float v : {0.0f, half})
                for (const float u : {0.0f, half}) boundZonal(texels, references, {part.u + u, part.v + v, half}, depth + 1);
            return;
        }
        boundQuad(pairs, missing);
    }
    static constexpr int kZonalDepth = 3;
    static constexpr double kZonalShare = 0.05;

    static AxisCone coneOf(const Controls& bands) {
        std::array<glm::vec3, kControls> vectors;
        double largest = 0;
        for (std::size_t k = 0; k < kControls; ++k) {
            vectors[k] = bands[k].c[5];
            for (int i = 1; i < 4; ++i) largest = std::max(largest, static_cast<double>(glm::length(bands[k].c[i])));
        }
        return axisCone(vectors, kRounding * largest);
    }

    bool isWorthSplitting(const Pairs& pairs, const std::array<double, kChannels>& missing) const {
        for (std::size_t c = 0; c < kChannels; ++c) {
            double error = 0, specular = 0;
            for (const ErrorPair& pair : pairs[c]) {
                error = std::max(error, bandSum(bandNorms(pair.error), kExitNorm));
                specular = std::max(specular, bandSum(bandNorms(pair.error), specularSuprema_));
            }
            if (missing[c] <= kZonalShare * error) continue;
            const double rounding = kRounding * magnitudeOf(pairs[c]) + missing[c];
            if (specular_.count() > 0 && specular + 4 * rounding > kFloor * worst_.back().specular) return true;
            if (!staysWithin(pairs[c], kFloor, rounding, worst_.back().diffuse)) return true;
        }
        return false;
    }

    const Layout& layout_;
    const CookedLightMap& map_;
    const LightMapSampling& sampling_;
    const ShadingMatrix& specular_;
    const lighting::ShBands& specularSuprema_;
    float perKey_;
    const DecodedLightMapRows& texels_;
    const formats::LightMapBand& reference_;
    LightMapErrors errors_;
    std::vector<Worst> worst_;
    ErrorShader shader_;
};

}  // namespace

formats::Result<LightMapVerifier> LightMapVerifier::create(const CookedLightMap& map, const LightMapShading& shading,
                                                           const LightMapSampling& sampling, double key) {
    if (map.width < 1 || map.height < 1)
        return formats::failure(formats::ErrorCode::WrongShape, "light map layout " + map.layout,
                                "found " + std::to_string(map.width) + "x" + std::to_string(map.height) + " texels, expected at least 1x1");
    if (auto error = checkShading(shading)) return tl::make_unexpected(*error);
    auto layout = layouts::layoutOf(map);
    if (!layout) return tl::make_unexpected(layout.error());

    auto state = std::make_unique<State>();
    state->map = map;
    state->shading = shading;
    state->sampling = sampling;
    state->perKey = key > 0 ? static_cast<float>(1 / key) : 1.0f;
    state->layout = *layout;
    state->textures = layouts::texturesOf(*layout);
    if (state->isFlat()) {
        state->diffuse = flatMatrix();
    } else {
        state->diffuse = diffuseMatrix(shading.normalCount);
        if (shading.specular) {
            state->specular = specularMatrix(shading);
            state->specularSuprema = specularBandSuprema(shading);
        }
    }
    return LightMapVerifier(std::move(state));
}

LightMapVerifier::LightMapVerifier(std::unique_ptr<const State> state) : state_(std::move(state)) {}
LightMapVerifier::LightMapVerifier(LightMapVerifier&&) noexcept = default;
LightMapVerifier& LightMapVerifier::operator=(LightMapVerifier&&) noexcept = default;
LightMapVerifier::~LightMapVerifier() = default;

const std::vector<LightMapVerifier::TextureNeed>& LightMapVerifier::textures() const {
    return state_->textures;
}

LightMapErrors LightMapVerifier::noErrors() const {
    return std::visit(
        [](const auto& layout) {
            using Layout = std::decay_t<decltype(layout)>;
            std::vector<LightMapErrors::Stage> stages;
            const auto stage = [](const char* name) { return LightMapErrors::Stage{name, ErrorAccumulator(1), ErrorAccumulator(1)}; };
            for (const char* early : Layout::kEarlyStages) stages.push_back(stage(early));
            stages.push_back(stage(Layout::kFinalStage));
            stages.push_back(stage("magnified"));
            return LightMapErrors(std::move(stages));
        },
        state_->layout);
}

LightMapErrors LightMapVerifier::verifyRows(const DecodedLightMapRows& texels, const formats::LightMapBand& reference, int firstRow,
                                            int rowCount) const {
    assert(texels.textures.size() == state_->textures.size());
    assert(reference.sh.width() == state_->map.width && firstRow >= reference.firstRow && firstRow >= texels.firstRow);
    assert(reference.firstRow + reference.sh.height() >= std::min(state_->map.height, firstRow + rowCount + state_->sampling.bounds));
    return std::visit(
        [&](const auto& layout) {
            return RowVerifier(layout, *this, state_->map, state_->sampling, state_->diffuse, state_->specular, state_->specularSuprema,
                               state_->perKey, texels, reference)
                .run(firstRow, rowCount);
        },
        state_->layout);
}

formats::Image<lighting::ShRgb> LightMapVerifier::reconstruct(const DecodedLightMapRows& texels, int firstRow, int rowCount) const {
    assert(texels.textures.size() == state_->textures.size() && firstRow >= texels.firstRow);
    formats::Image<lighting::ShRgb> out(state_->map.width, rowCount);
    std::visit(
        [&](const auto& layout) {
            using Layout = std::decay_t<decltype(layout)>;
            for (int y = 0; y < rowCount; ++y)
                for (int x = 0; x < state_->map.width; ++x) {
                    Texels<Layout::kLayers> filtered{};
                    std::size_t layer = 0;
                    for (const auto& texture : texels.textures)
                        for (const formats::Image<glm::vec4>& image : texture)
                            filtered[layer++] = image.at(x, firstRow - texels.firstRow + y);
                    const LcSh sh = layouts::decodeAt(layout, x, firstRow + y).decode(filtered);
                    std::copy_n(sh.c, kCount, out.at(x, y).begin());
                }
        },
        state_->layout);
    return out;
}

}  // namespace verify
