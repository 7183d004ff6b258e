#include "verify/light_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <span>

#include "lighting/radiometry.h"
#include "verify/light_map_bound.h"
#include "verify/light_map_deviation.h"
#include "verify/light_map_freedom.h"
#include "verify/light_map_layouts.h"
#include "verify/light_map_shading.h"

namespace verify {

/// How a map is shaded and bounded, whatever its layout.
struct ShadingSetup {
    ShadingMatrix diffuse, specular;
    std::vector<Response> responses;      ///< area specular, for the bounds
    lighting::ShBands largestResponse{};  ///< their norms, each at its largest
    std::vector<FormatFreedom> freedom;   ///< of each layer; empty: an ideal sampler
    bool hasSpecular() const { return !responses.empty(); }
};

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
/// What is left out is clearly under the worst: which of two bounds alike is found first must not show in the last bit.
constexpr double kClearly = 1 - 1e-9;
/// What float sums of nine products may add to a sampled error, as a part of it.
constexpr double kShadingRounding = 2e-6;

using Channel = lighting::Sh;
using Channels = std::array<Channel, kChannels>;
/// Lengths of what each channel's error may have beyond its numbers, by band.
using ChannelSlack = std::array<lighting::ShBands, kChannels>;

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

/// Squared lengths by band and channel.
using Squares = std::array<glm::vec3, 3>;
/// The largest of each among these.
Squares largestSquares(std::span<const LcSh> each) {
    // By plain floats: the hottest sums of the bounds, which run in lanes this way.
    constexpr std::size_t kFloats = kCount * kChannels;
    static_assert(sizeof(LcSh) == kFloats * sizeof(float));
    std::array<float, 3 * kChannels> largest{};
    for (const LcSh& sh : each) {
        std::array<float, kFloats> square;
        std::memcpy(square.data(), &sh, sizeof(sh));
        for (float& value : square) value *= value;
        std::array<float, 3 * kChannels> sums;
        for (std::size_t c = 0; c < kChannels; ++c) {
            const auto at = [&](std::size_t i) { return square[kChannels * i + c]; };
            sums[c] = at(0);
            sums[kChannels + c] = at(1) + at(2) + at(3);
            sums[2 * kChannels + c] = at(4) + at(5) + at(6) + at(7) + at(8);
        }
        // What is not a number stays: no comparison with it is true.
        for (std::size_t i = 0; i < sums.size(); ++i) largest[i] = sums[i] <= largest[i] ? largest[i] : sums[i];
    }
    Squares out;
    std::memcpy(&out, largest.data(), sizeof(out));
    return out;
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
    ShadingSetup setup;

    bool isFlat() const { return std::holds_alternative<layouts::Flat>(layout); }
};

namespace {

/// One run over rows of a map whose layout is known at compile time.
template <class Layout>
class RowVerifier {
public:
    RowVerifier(const Layout& layout, const LightMapVerifier& verifier, const CookedLightMap& map, const LightMapSampling& sampling,
                const ShadingSetup& setup, float perKey, const DecodedLightMapRows& texels, const formats::LightMapBand& reference)
        : layout_(layout),
          map_(map),
          sampling_(sampling),
          setup_(setup),
          perKey_(perKey),
          texels_(texels),
          reference_(reference),
          errors_(verifier.noErrors()),
          worst_(errors_.accumulators.size()),
          shader_(setup.diffuse, setup.specular),
          worstSampled_{{{-1, -1}, {-1, -1}}} {
        for (const auto& texture : texels.spans)
            for (const formats::Image<glm::vec4>& image : texture) spans_.push_back(&image);
        if constexpr (requires { Layout::kCodeCount; }) prepareClusters();
    }

    LightMapErrors run(int firstRow, int rowCount) {
        Row current;
        for (int y = firstRow; y < firstRow + rowCount; ++y) {
            loadRow(y, current);
            for (int x = 0; x < map_.width; ++x)
                if (current.covered[index(x)] != 0) centre(current, x, y);
        }
        if (sampling_.bounds) {
            if (sampling_.positionsPerQuad > 0)
                forEachQuad(firstRow, rowCount, [&](const Corners& corners, int x, int y) {
                    for (int sample = 0; sample < sampling_.positionsPerQuad; ++sample) magnified(corners, x, y, sample);
                });
            // Where samples were worst the bounds are likely to be: after those most quads are settled at a glance.
            for (const auto& [x, y] : worstSampled_)
                if (x >= 0) oneQuad(x, y);
            std::vector<Doubtful> doubtful;
            forEachQuad(firstRow, rowCount,
                        [&](const Corners& corners, int x, int y) { boundQuad(corners.texels, corners.references, x, y, &doubtful); });
            settle(std::move(doubtful));
        }
        for (std::size_t stage = 0; stage < worst_.size(); ++stage) {
            errors_.accumulators[stage].diffuse.addBound(worst_[stage].diffuse);
            if (setup_.hasSpecular()) errors_.accumulators[stage].specular.addBound(worst_[stage].specular);
        }
        return std::move(errors_);
    }

    LightMapVerifier::QuadBound oneQuad(int x, int y) {
        Row above, below;
        loadTexels(x, 2, y, above);
        loadTexels(x, 2, y + 1, below);
        const Corners corners = cornersOf(above, below, 0);
        boundQuad(corners.texels, corners.references, x, y, nullptr);
        return {worst_.back().diffuse, worst_.back().specular};
    }

private:
    using LayerTexels = Texels<Layout::kLayers>;
    static constexpr int kNodes = Layout::kDegree + 1;
    static constexpr std::size_t kControls = static_cast<std::size_t>(kNodes) * kNodes;
    using Controls = std::array<LcSh, kControls>;
    using Pairs = std::array<std::array<ErrorPair, kControls>, kChannels>;
    static std::size_t index(int x) { return static_cast<std::size_t>(x); }

    /// A row of the map as this pass needs it; light in units of the key.
    struct Row {
        std::vector<std::uint8_t> covered;
        std::vector<LcSh> reference;
        std::vector<LayerTexels> texels;
    };

    struct Corners {
        std::array<const LayerTexels*, 4> texels;
        std::array<const LcSh*, 4> references;
    };
    static Corners cornersOf(const Row& above, const Row& below, int x) {
        const std::size_t i = index(x);
        return {{&above.texels[i], &above.texels[i + 1], &below.texels[i], &below.texels[i + 1]},
                {&above.reference[i], &above.reference[i + 1], &below.reference[i], &below.reference[i + 1]}};
    }
    /// work(corners, x, y) for every quad of covered texels that begins in these rows.
    template <class Work>
    void forEachQuad(int firstRow, int rowCount, Work&& work) {
        Row above, below;
        loadRow(firstRow, above);
        for (int y = firstRow; y < std::min(firstRow + rowCount, map_.height - 1); ++y) {
            loadRow(y + 1, below);
            for (int x = 0; x + 1 < map_.width; ++x)
                if (above.covered[index(x)] != 0 && above.covered[index(x + 1)] != 0 && below.covered[index(x)] != 0 &&
                    below.covered[index(x + 1)] != 0)
                    work(cornersOf(above, below, x), x, y);
            std::swap(above, below);
        }
    }

    void loadRow(int y, Row& row) const { loadTexels(0, map_.width, y, row); }
    void loadTexels(int firstX, int count, int y, Row& row) const {
        row.covered.resize(index(count));
        row.reference.resize(index(count));
        row.texels.resize(index(count));
        const int bandRow = y - reference_.firstRow, texelRow = y - texels_.firstRow;
        for (int i = 0; i < count; ++i) {
            const int x = firstX + i;
            row.covered[index(i)] = reference_.covered.at(x, bandRow);
            if (row.covered[index(i)] == 0) continue;
            row.reference[index(i)] = referenceAt(x, bandRow);
            std::size_t layer = 0;
            for (const auto& texture : texels_.textures)
                for (const formats::Image<glm::vec4>& image : texture) row.texels[index(i)][layer++] = image.at(x, texelRow);
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
            if (sampling_.bounds) {
                // Stages before the last are told as an ideal sampler has them.
                const bool isLast = stage == Layout::kEarlyStages.size();
                boundCentre(stage, error, reference, isLast ? centreFreedom(row.texels[index(x)], x, y) : ChannelSlack{});
            }
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

    void boundCentre(std::size_t stage, const LcSh& error, const LcSh& reference, const ChannelSlack& freedom) {
        ChannelSlack slack = freedom;
        addLengths(slack, error, kShadingRounding);
        if (isCertainlyWithin(worst_[stage], largestSquares({&error, 1}), slack)) return;
        const Channels errors = channelsOf(error), references = channelsOf(reference);
        for (std::size_t c = 0; c < kChannels; ++c) {
            const std::array<ErrorPair, 1> pair = {ErrorPair{errors[c], references[c]}};
            raise(worst_[stage], pair, slack[c]);
        }
    }

    /// Takes the pairs of one channel into the worst so far.
    void raise(Worst& worst, std::span<const ErrorPair> pairs, const lighting::ShBands& slack) const {
        const auto take = [&](std::span<const Response> responses, double& largest) {
            if (!staysWithin(pairs, responses, kFloor, slack, kClearly * largest))
                largest = std::max(largest, localErrorBound(pairs, responses, kFloor, slack));
        };
        take({&kExitResponse, 1}, worst.diffuse);
        take(setup_.responses, worst.specular);
    }

    static constexpr std::size_t kSigns = 8;
    /// The signed sums of a group, each with the references of the corners.
    struct FreeGroup {
        std::array<ErrorPair, 4 * kSigns> pairs;
        lighting::ShBands rounding{};
        void set(std::size_t i, const ErrorPair& pair) {
            pairs[i] = pair;
            const lighting::ShBands lengths = bandNorms(pair.error);
            for (std::size_t l = 0; l < 3; ++l) rounding[l] = std::max(rounding[l], kRounding * lengths[l]);
        }
    };
    /// The same with what a sampler is free to do.
    /// all  the lengths of all that errors may have beyond their numbers; slack: but for the groups of `off`
    /// Groups are long where light is, and short in the dark: |e + g| / (|r| + floor) is at most the sum of the bounds of |e| and of |g|
    /// over the same, which is often far less than the bound of |e| with the group's length beside it. g's reference is bilinear, so that
    /// its corners are all that it takes.
    template <std::size_t kGroups>
    void raiseFree(const Pairs& pairs, const std::array<const LcSh*, 4>& references, const ChannelSlack& all, const ChannelSlack& slack,
                   const layouts::Deviation<kGroups>& off) {
        std::vector<std::array<Channels, kSigns>> sums(kGroups);
        for (std::size_t group = 0; group < kGroups; ++group) {
            const std::array<LcSh, kSigns> signedSums = signedSumsOf(off.groups[group]);
            for (std::size_t i = 0; i < kSigns; ++i) sums[group][i] = channelsOf(scaled(signedSums[i], perKey_));
        }
        std::array<Channels, 4> corners;
        for (std::size_t i = 0; i < 4; ++i) corners[i] = channelsOf(*references[i]);
        for (std::size_t c = 0; c < kChannels; ++c) {
            std::array<FreeGroup, kGroups> groups;
            bool hasGroups = false;
            const auto makeGroups = [&] {
                for (std::size_t group = 0; group < kGroups && !hasGroups; ++group)
                    for (std::size_t i = 0; i < groups[group].pairs.size(); ++i)
                        groups[group].set(i, {sums[group][i / 4][c], corners[i % 4][c]});
                hasGroups = true;
            };
            const auto take = [&](std::span<const Response> responses, double& largest) {
                if (responses.empty() || staysWithin(pairs[c], responses, kFloor, all[c], kClearly * largest)) return;
                if constexpr (kGroups > 0) {
                    makeGroups();
                    if (staysWithinInParts(pairs[c], slack[c], groups, responses, kClearly * largest)) return;
                }
                double bound = localErrorBound(pairs[c], responses, kFloor, all[c]);
                if (bound <= largest) return;
                if constexpr (kGroups > 0) {
                    double sum = localErrorBound(pairs[c], responses, kFloor, slack[c], bound);
                    for (const FreeGroup& group : groups)
                        if (sum < bound) sum += localErrorBound(group.pairs, responses, kFloor, group.rounding, bound - sum);
                    bound = std::min(bound, sum);
                }
                largest = std::max(largest, bound);
            };
            take({&kExitResponse, 1}, worst_.back().diffuse);
            take(setup_.responses, worst_.back().specular);
        }
    }
    /// Whether errors and groups each stay within a part of the limit, dealt out by their lengths.
    template <std::size_t kGroups>
    bool staysWithinInParts(std::span<const ErrorPair> pairs, const lighting::ShBands& slack, const std::array<FreeGroup, kGroups>& groups,
                            std::span<const Response> responses, double limit) const {
        const lighting::ShBands norms = responses.front().norms();
        const double error = bandSum(largestLengths(pairs), norms) + bandSum(slack, norms);
        std::array<double, kGroups> parts;
        double sum = error;
        for (std::size_t group = 0; group < kGroups; ++group)
            sum += parts[group] = bandSum(largestLengths(groups[group].pairs), norms) + bandSum(groups[group].rounding, norms);
        if (!staysWithin(pairs, responses, kFloor, slack, limit * (error / sum))) return false;
        for (std::size_t group = 0; group < kGroups; ++group)
            if (!staysWithin(groups[group].pairs, responses, kFloor, groups[group].rounding, limit * (parts[group] / sum))) return false;
        return true;
    }
    static lighting::ShBands largestLengths(std::span<const ErrorPair> pairs) {
        lighting::ShBands largest{};
        for (const ErrorPair& pair : pairs) {
            const lighting::ShBands lengths = bandNorms(pair.error);
            for (std::size_t l = 0; l < 3; ++l) largest[l] = std::max(largest[l], lengths[l]);
        }
        return largest;
    }

    // ---- what a sampler is free to do ----

    /// Of one layer at texels (x, y) to (x + across, y + down): between them, or at one of them alone.
    glm::vec4 decodeFreedom(std::size_t layer, int x, int y, int reach) const {
        const FormatFreedom& format = setup_.freedom[layer];
        if (!format.hasSpans() || spans_.empty()) return format.decoded;
        glm::vec4 span(0);
        for (int blockY = (y - texels_.firstRow) / 4; blockY <= (y + reach - texels_.firstRow) / 4; ++blockY)
            for (int blockX = x / 4; blockX <= (x + reach) / 4; ++blockX) span = glm::max(span, spans_[layer]->at(blockX, blockY));
        return format.decoded + format.perSpan * span;
    }
    /// What the decode of texel (x, y) may be off, over boxes of texels.
    auto deviation(const layouts::Boxes<Layout::kLayers>& boxes, int x, int y) const {
        if constexpr (requires { Layout::kCodeCount; })
            return layouts::deviationOf<Layout::kCodeCount, Layout::kResidualCount>(layout_.at(x, y), boxes);
        else
            return layouts::Deviation<0>{layouts::deviationOf(layout_, boxes), {}};
    }
    /// Its band lengths, quickly, by the lengths of every vector, or exactly, by the sums with every choice of signs: the longest are among
    /// them. Lengths do not ask for a whole group's sign, which halves the choices.
    template <std::size_t kGroups>
    ChannelSlack lengthsOf(const layouts::Deviation<kGroups>& off, bool isExact) const {
        ChannelSlack slack{};
        addLengths(slack, off.absolute, static_cast<double>(perKey_));
        for (const std::array<LcSh, 4>& group : off.groups) {
            if (!isExact) {
                for (const LcSh& vector : group) addLengths(slack, vector, static_cast<double>(perKey_));
                continue;
            }
            addLargestLengths(slack, signedSumsOf(group), static_cast<double>(perKey_));
        }
        return slack;
    }
    /// Of each cluster, what the decode may be off for light of 1 in texture "l0" and codes anywhere in [0, 1]: a quick bound for most
    /// quads, as all of it is proportional to the light. Only where codes cannot leave [0, 1], and light is off by a part of itself.
    void prepareClusters() {
        if (setup_.freedom.empty() || setup_.freedom[0].absolute != 0 || setup_.freedom[0].decoded != glm::vec4(0)) return;
        layouts::Boxes<Layout::kLayers> boxes;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            const FormatFreedom& format = setup_.freedom[layer];
            if (layer > 0 && format.relative != 0) return;
            boxes[layer] = {glm::vec4(0.5f), glm::vec4(0.5f), format.decoded + format.perSpan + format.absolute + format.relative};
        }
        const layouts::BasisTables& tables = *layout_.tables;
        const std::size_t count = std::max(tables.first3.size(), tables.first4.size());
        for (std::size_t cluster = 0; cluster < count; ++cluster)
            clusterSlack_.push_back(lengthsOf(
                layouts::deviationOf<Layout::kCodeCount, Layout::kResidualCount>(typename Layout::Decode{&tables, cluster}, boxes), true));
    }
    /// Whether the quick bound settles it. slack: what else errors may have
    bool isCertainlyWithinFreely(const std::array<const LayerTexels*, 4>& texels, int x, int y, const Squares& errors,
                                 const ChannelSlack& slack) const {
        if constexpr (requires { Layout::kCodeCount; }) {
            if (clusterSlack_.empty()) return false;
            const ChannelSlack& unit = clusterSlack_[layout_.at(x, y).cluster];
            ChannelSlack all = slack;
            for (std::size_t c = 0; c < kChannels; ++c) {
                float light = 0;
                for (const LayerTexels* corner : texels) light = std::max(light, std::abs((*corner)[0][static_cast<int>(c)]));
                for (std::size_t l = 0; l < 3; ++l) all[c][l] += static_cast<double>(kOutward * light) * unit[c][l];
            }
            return isCertainlyWithin(worst_.back(), errors, all);
        }
        return false;
    }
    static std::array<LcSh, kSigns> signedSumsOf(const std::array<LcSh, 4>& group) {
        std::array<LcSh, kSigns> sums;
        for (std::size_t signs = 0; signs < sums.size(); ++signs)
            for (std::size_t i = 0; i < kCount; ++i) {
                glm::vec3 sum = group[3].c[i];
                for (std::size_t j = 0; j < 3; ++j) sum += (signs >> j & 1) == 0 ? group[j].c[i] : -group[j].c[i];
                sums[signs].c[i] = sum;
            }
        return sums;
    }
    ChannelSlack centreFreedom(const LayerTexels& texels, int x, int y) const {
        if (setup_.freedom.empty()) return {};
        layouts::Boxes<Layout::kLayers> boxes;
        bool isFree = false;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            boxes[layer] = {texels[layer], glm::vec4(0), decodeFreedom(layer, x, y, 0)};
            isFree = isFree || boxes[layer].freedom != glm::vec4(0);
        }
        return isFree ? lengthsOf(deviation(boxes, x, y), true) : ChannelSlack{};
    }
    layouts::Boxes<Layout::kLayers> quadBoxes(const std::array<const LayerTexels*, 4>& texels, int x, int y) const {
        layouts::Boxes<Layout::kLayers> boxes;
        for (std::size_t layer = 0; layer < boxes.size(); ++layer) {
            const auto at = [&](std::size_t corner) -> const glm::vec4& { return (*texels[corner])[layer]; };
            const glm::vec4 low = glm::min(glm::min(at(0), at(1)), glm::min(at(2), at(3))),
                            high = glm::max(glm::max(at(0), at(1)), glm::max(at(2), at(3)));
            TexelBox& box = boxes[layer];
            box.centre = 0.5f * (low + high);
            box.half = kOutward * (0.5f * (high - low));
            const FormatFreedom& format = setup_.freedom[layer];
            box.freedom = decodeFreedom(layer, x, y, 1) + format.absolute + format.relative * glm::max(glm::abs(low), glm::abs(high));
        }
        return boxes;
    }
    /// What the filter's fractions move the light of a decode of degree kDegree: a polynomial in Bernstein form changes by at most its
    /// degree times the difference of neighbouring controls; of the reference those are the texels themselves.
    void addFractions(ChannelSlack& slack, const std::array<const LcSh*, 4>& references, const Squares& error) const {
        const auto steps = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
            const std::array<LcSh, 2> edges = {difference(*references[a], *references[b]), difference(*references[c], *references[d])};
            return largestSquares(edges);
        };
        const Squares across = steps(1, 0, 3, 2), down = steps(2, 0, 3, 1);
        constexpr double kBend = 4.0 * Layout::kDegree;
        for (std::size_t l = 0; l < 3; ++l) {
            for (std::size_t c = 0; c < kChannels; ++c) {
                const auto length = [&](const Squares& squares) { return outwardLength(squares[l][static_cast<int>(c)]); };
                slack[c][l] += kFractionFreedom * (length(across) + length(down) + kBend * length(error));
            }
        }
    }
    /// factor times the lengths of the bands; of each band the largest.
    static void addLengths(ChannelSlack& slack, const LcSh& sh, double factor) { addLargestLengths(slack, {&sh, 1}, factor); }
    static void addLargestLengths(ChannelSlack& slack, std::span<const LcSh> each, double factor) {
        const Squares squares = largestSquares(each);
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l) slack[c][l] += factor * outwardLength(squares[l][static_cast<int>(c)]);
    }
    static ChannelSlack sumOf(const ChannelSlack& a, const ChannelSlack& b) {
        ChannelSlack out = a;
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l) out[c][l] += b[c][l];
        return out;
    }
    /// From a sum of squares of floats: a few units in the last place, and what squares lose under the smallest float.
    static double outwardLength(float square) { return square == 0 ? 0 : kOutwardLength * std::sqrt(static_cast<double>(square)) + kTiny; }
    static constexpr double kOutwardLength = 1 + 1e-5, kTiny = 1e-18;
    static constexpr float kOutward = 1 + 1e-5f;

    /// A quad that is not settled at a glance, and its place in the queue: the more it could raise the worst, the earlier it is looked at,
    /// and the fewer are left for a closer look after it.
    struct Doubtful {
        int x, y;
        double diffuse, specular;
    };
    Doubtful doubtfulOf(int x, int y, const Squares& error, const ChannelSlack& slack, const std::array<const LcSh*, 4>& references) const {
        Doubtful out{x, y, 0, 0};
        const auto raise = [](double& largest, double value) {
            largest = value <= largest ? largest : std::isfinite(value) ? value : kAll;
        };
        for (std::size_t c = 0; c < kChannels; ++c) {
            lighting::ShBands lengths = slack[c];
            for (std::size_t l = 0; l < 3; ++l) lengths[l] += outwardLength(error[l][static_cast<int>(c)]);
            double light = 0;
            for (const LcSh* reference : references) light += 0.25 * static_cast<double>(reference->c[0][static_cast<int>(c)]);
            light = std::max(light, 0.0);
            raise(out.diffuse, bandSum(lengths, kExitNorm) / (kFloor + kExitNorm[0] * light));
            raise(out.specular, bandSum(lengths, setup_.largestResponse) / (kFloor + setup_.largestResponse[0] * light));
        }
        return out;
    }
    static constexpr double kAll = std::numeric_limits<double>::max();

    void settle(std::vector<Doubtful> doubtful) {
        constexpr std::size_t kFirst = 4;
        std::ranges::stable_sort(doubtful, std::greater{}, &Doubtful::diffuse);
        for (std::size_t i = 0; i < std::min(kFirst, doubtful.size()); ++i) oneQuad(doubtful[i].x, doubtful[i].y);
        std::ranges::stable_sort(doubtful, std::greater{}, &Doubtful::specular);
        for (const Doubtful& each : doubtful) oneQuad(each.x, each.y);
    }

    /// later  where quads that need a closer look are put down; null: here and now
    void boundQuad(const std::array<const LayerTexels*, 4>& texels, const std::array<const LcSh*, 4>& references, int x, int y,
                   std::vector<Doubtful>* later) {
        if constexpr (layouts::Zonal<Layout>) {
            boundZonal(texels, references, {}, 0, zonalFreedom(texels, references, x, y));
        } else {
            Controls errors, filtered;
            for (int corner = 0; corner < 4; ++corner) {
                if (!isNewDecode(x, y, corner)) continue;
                const auto error = [&](const LayerTexels& t, const LcSh& reference) {
                    return difference(decoded(t, x + corner % 2, y + corner / 2), reference);
                };
                evaluateControls(texels, references, {}, error, errors, filtered);
                const Squares errorSquares = largestSquares(errors);
                ChannelSlack slack{};
                addRounding(slack, errorSquares, referenceSquares(references));
                if (setup_.freedom.empty()) {
                    if (isCertainlyWithin(worst_.back(), errorSquares, slack)) continue;
                    if (later != nullptr) return later->push_back(doubtfulOf(x, y, errorSquares, slack, references));
                    const Pairs pairs = pairsOf(errors, filtered);
                    for (std::size_t c = 0; c < kChannels; ++c) raise(worst_.back(), pairs[c], slack[c]);
                    continue;
                }
                addFractions(slack, references, errorSquares);
                if (isCertainlyWithinFreely(texels, x + corner % 2, y + corner / 2, errorSquares, slack)) continue;
                const auto off = deviation(quadBoxes(texels, x, y), x + corner % 2, y + corner / 2);
                if (isCertainlyWithin(worst_.back(), errorSquares, sumOf(slack, lengthsOf(off, false)))) continue;
                const ChannelSlack all = sumOf(slack, lengthsOf(off, true));
                if (isCertainlyWithin(worst_.back(), errorSquares, all)) continue;
                if (later != nullptr) return later->push_back(doubtfulOf(x, y, errorSquares, all, references));
                addLengths(slack, off.absolute, static_cast<double>(perKey_));
                raiseFree(pairsOf(errors, filtered), references, all, slack, off);
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

    void magnified(const Corners& corners, int x, int y, int sample) {
        const auto place = 2 * ((static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(map_.width) + static_cast<std::uint64_t>(x)) *
                                    static_cast<std::uint64_t>(sampling_.positionsPerQuad) +
                                static_cast<std::uint64_t>(sample));
        const Filtered at =
            filter(corners.texels, corners.references, hashedFraction(sampling_.seed, place), hashedFraction(sampling_.seed, place + 1));
        setReference(at.reference, x, y);
        const LightMapErrors::Stage& stage = errors_.accumulators.back();
        const std::array<double, 2> before = {stage.diffuse.maxSampled(), stage.specular.maxSampled()};
        addErrors(worst_.size() - 1, difference(decoded(at.texels, x, y), at.reference));
        const std::array<double, 2> after = {stage.diffuse.maxSampled(), stage.specular.maxSampled()};
        for (std::size_t kind = 0; kind < after.size(); ++kind)
            if (after[kind] > before[kind]) worstSampled_[kind] = {x, y};
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

    static Pairs pairsOf(const Controls& errors, const Controls& filtered) {
        Pairs pairs;
        for (std::size_t k = 0; k < kControls; ++k) {
            const Channels error = channelsOf(errors[k]), reference = channelsOf(filtered[k]);
            for (std::size_t c = 0; c < kChannels; ++c) pairs[c][k] = {error[c], reference[c]};
        }
        return pairs;
    }

    /// A bilinear reference is nowhere longer than at a corner.
    static Squares referenceSquares(const std::array<const LcSh*, 4>& references) {
        const std::array<LcSh, 4> each = {*references[0], *references[1], *references[2], *references[3]};
        return largestSquares(each);
    }
    /// What float evaluations of the decode may be off, after their conversion to Bernstein form.
    static void addRounding(ChannelSlack& slack, const Squares& error, const Squares& reference) {
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t l = 0; l < 3; ++l)
                slack[c][l] +=
                    kRounding * (outwardLength(error[l][static_cast<int>(c)]) + outwardLength(reference[l][static_cast<int>(c)]));
    }
    /// A cheap yes, for most texels and quads: the largest norms of each band together, whichever controls they come from, are under the
    /// worst so far.
    bool isCertainlyWithin(const Worst& worst, const Squares& error, const ChannelSlack& slack) const {
        static const lighting::ShBands kExitNorms = kExitResponse.norms();
        for (std::size_t c = 0; c < kChannels; ++c) {
            lighting::ShBands lengths = slack[c];
            for (std::size_t l = 0; l < 3; ++l) lengths[l] += outwardLength(error[l][static_cast<int>(c)]) + kTiny;
            // Not "greater": what is not a number has to be looked at.
            if (!(bandSum(lengths, kExitNorms) <= kFloor * worst.diffuse)) return false;
            if (!(bandSum(lengths, setup_.largestResponse) <= kFloor * worst.specular)) return false;
        }
        return true;
    }

    /// What a sampler's freedom does to bands() and to the vector of the axis.
    struct ZonalFreedom {
        ChannelSlack slack{};
        double axis = 0;
    };
    ZonalFreedom zonalFreedom(const std::array<const LayerTexels*, 4>& texels, const std::array<const LcSh*, 4>& references, int x,
                              int y) const {
        ZonalFreedom out;
        if (setup_.freedom.empty()) return out;
        const LcSh off = scaled(deviation(quadBoxes(texels, x, y), x, y).absolute, perKey_);
        addLengths(out.slack, off, 1);
        Controls bands, filtered;
        evaluateControls(
            texels, references, {}, [&](const LayerTexels& t, const LcSh&) { return bandsAndAxis(t); }, bands, filtered);
        const glm::vec3 weights = glm::abs(layout_.k.luminance);
        out.axis = kOutwardLength * static_cast<double>(glm::length(
                                        glm::vec3(glm::dot(weights, off.c[3]), glm::dot(weights, off.c[1]), glm::dot(weights, off.c[2]))));
        // As in addFractions, from the controls themselves: lengths of the axis' vector are in c[5].
        for (int axis = 0; axis < 2; ++axis) {
            const int step = axis == 0 ? 1 : kNodes;
            ChannelSlack largest{};
            double turned = 0;
            for (int k = 0; k < static_cast<int>(kControls); ++k) {
                if ((axis == 0 ? k % kNodes : k / kNodes) == kNodes - 1) continue;
                LcSh moved = difference(bands[static_cast<std::size_t>(k + step)], bands[static_cast<std::size_t>(k)]);
                turned = std::max(turned, static_cast<double>(glm::length(moved.c[5])));
                moved.c[5] = glm::vec3(0);
                ChannelSlack lengths{};
                addLengths(lengths, moved, 1);
                for (std::size_t c = 0; c < kChannels; ++c)
                    for (std::size_t l = 0; l < 3; ++l) largest[c][l] = std::max(largest[c][l], lengths[c][l]);
            }
            constexpr double kSteepest = kOutwardLength * kFractionFreedom * Layout::kDegree;
            for (std::size_t c = 0; c < kChannels; ++c)
                for (std::size_t l = 0; l < 3; ++l) out.slack[c][l] += kSteepest * largest[c][l];
            out.axis += kSteepest * turned;
        }
        return out;
    }
    /// bands(), and beside the zonal coefficient in c[4] the vector of the axis in c[5]: both are polynomials.
    LcSh bandsAndAxis(const LayerTexels& t) const {
        LcSh sh = scaled(layout_.bands(t), perKey_);
        const glm::vec3& weights = layout_.k.luminance;
        sh.c[5] = {glm::dot(weights, sh.c[3]), glm::dot(weights, sh.c[1]), glm::dot(weights, sh.c[2])};
        return sh;
    }

    /// A layout whose band 2 is z(p) Y(a(p)), z a polynomial and a(p) the axis of another, is bounded as the polynomial z(p) Y(a0) with one
    /// axis a0 for the part, and at most |z| |Y(a) - Y(a0)| beside it (axisCone). Where that is much of the error and could be the map's
    /// worst, the part is looked at in quarters: axes turn less in them.
    void boundZonal(const std::array<const LayerTexels*, 4>& texels, const std::array<const LcSh*, 4>& references, const Part& part,
                    int depth, const ZonalFreedom& freedom) {
        Controls bands, filtered;
        evaluateControls(
            texels, references, part, [&](const LayerTexels& t, const LcSh&) { return bandsAndAxis(t); }, bands, filtered);
        const AxisCone cone = coneOf(bands, freedom.axis);
        std::array<double, kChannels> turned{};
        for (LcSh& sh : bands)
            for (std::size_t c = 0; c < kChannels; ++c)
                turned[c] = std::max(turned[c], cone.deviation * static_cast<double>(std::abs(sh.c[4][static_cast<int>(c)])));
        for (std::size_t k = 0; k < kControls; ++k) bands[k] = difference(shaders::lcZonalBand2(bands[k], cone.axis), filtered[k]);
        ChannelSlack slack = freedom.slack;
        const Squares squares = largestSquares(bands);
        addRounding(slack, squares, referenceSquares(references));
        for (std::size_t c = 0; c < kChannels; ++c) slack[c][2] += turned[c];
        if (isCertainlyWithin(worst_.back(), squares, slack)) return;
        const Pairs pairs = pairsOf(bands, filtered);
        if (depth < kZonalDepth && isWorthSplitting(pairs, slack, turned)) {
            const float half = 0.5f * part.size;
            for (const float v : {0.0f, half})
                for (const float u : {0.0f, half}) boundZonal(texels, references, {part.u + u, part.v + v, half}, depth + 1, freedom);
            return;
        }
        for (std::size_t c = 0; c < kChannels; ++c) raise(worst_.back(), pairs[c], slack[c]);
    }
    static constexpr int kZonalDepth = 3;
    static constexpr double kZonalShare = 0.05;

    static AxisCone coneOf(const Controls& bands, double freedom) {
        std::array<glm::vec3, kControls> vectors;
        double largest = 0;
        for (std::size_t k = 0; k < kControls; ++k) {
            vectors[k] = bands[k].c[5];
            for (int i = 1; i < 4; ++i) largest = std::max(largest, static_cast<double>(glm::length(bands[k].c[i])));
        }
        return axisCone(vectors, kRounding * largest + freedom);
    }

    /// turned: what of the slack is due to the axis
    bool isWorthSplitting(const Pairs& pairs, const ChannelSlack& slack, const std::array<double, kChannels>& turned) const {
        for (std::size_t c = 0; c < kChannels; ++c) {
            double error = 0;
            for (const ErrorPair& pair : pairs[c]) error = std::max(error, bandSum(bandNorms(pair.error), kExitNorm));
            if (kExitNorm[2] * turned[c] <= kZonalShare * error) continue;
            if (!staysWithin(pairs[c], {&kExitResponse, 1}, kFloor, slack[c], worst_.back().diffuse)) return true;
            if (!staysWithin(pairs[c], setup_.responses, kFloor, slack[c], worst_.back().specular)) return true;
        }
        return false;
    }

    const Layout& layout_;
    const CookedLightMap& map_;
    const LightMapSampling& sampling_;
    const ShadingSetup& setup_;
    float perKey_;
    const DecodedLightMapRows& texels_;
    const formats::LightMapBand& reference_;
    LightMapErrors errors_;
    std::vector<Worst> worst_;
    ErrorShader shader_;
    std::vector<const formats::Image<glm::vec4>*> spans_;  ///< [layer]
    std::vector<ChannelSlack> clusterSlack_;               ///< [cluster], of learned layouts
    std::array<std::pair<int, int>, 2> worstSampled_;      ///< the quads with the worst diffuse and specular samples
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
    ShadingSetup& setup = state->setup;
    if (!map.formats.empty()) {
        if (map.formats.size() != state->textures.size())
            return formats::failure(
                formats::ErrorCode::WrongShape, "light map layout " + map.layout,
                "found formats of " + std::to_string(map.formats.size()) + " textures, expected " + std::to_string(state->textures.size()));
        for (std::size_t i = 0; i < map.formats.size(); ++i)
            setup.freedom.insert(setup.freedom.end(), static_cast<std::size_t>(state->textures[i].layerCount), freedomOf(map.formats[i]));
    }
    if (state->isFlat()) {
        setup.diffuse = flatMatrix();
    } else {
        setup.diffuse = diffuseMatrix(shading.normalCount);
        if (shading.specular) setup.specular = specularMatrix(shading);
        if (shading.specular && sampling.bounds) setup.responses = specularResponses(shading);
        for (const Response& response : setup.responses)
            for (std::size_t l = 0; l < 3; ++l) setup.largestResponse[l] = std::max(setup.largestResponse[l], response.norms()[l]);
    }
    return LightMapVerifier(std::move(state));
}

LightMapVerifier::LightMapVerifier(std::unique_ptr<const State> state) : state_(std::move(state)) {}
LightMapVerifier::LightMapVerifier(LightMapVerifier&&) noexcept = default;
LightMapVerifier& LightMapVerifier::operator=(LightMapVerifier&&) noexcept = default;
LightMapVerifier::~LightMapVerifier() = default;

formats::Result<std::vector<LightMapVerifier::TextureNeed>> LightMapVerifier::texturesOf(const CookedLightMap& map) {
    const auto layout = layouts::layoutOf(map);
    if (!layout) return tl::make_unexpected(layout.error());
    return layouts::texturesOf(*layout);
}

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
            return RowVerifier(layout, *this, state_->map, state_->sampling, state_->setup, state_->perKey, texels, reference)
                .run(firstRow, rowCount);
        },
        state_->layout);
}

LightMapVerifier::QuadBound LightMapVerifier::boundQuad(const DecodedLightMapRows& texels, const formats::LightMapBand& reference, int x,
                                                        int y) const {
    return std::visit(
        [&](const auto& layout) {
            return RowVerifier(layout, *this, state_->map, state_->sampling, state_->setup, state_->perKey, texels, reference)
                .oneQuad(x, y);
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
