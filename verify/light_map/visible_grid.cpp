#include "verify/light_map/visible_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>

#include "verify/error/perceptual_quantizer.h"
#include "verify/light_map/rounding.h"

namespace lightcook::verify {

namespace {

using lighting::ShBands;
using lighting::ShDouble;

constexpr std::size_t kBands = 3, kChannels = 3;
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// Numbers side by side. Every lane is computed as a scalar would be.
using Lanes = float __attribute__((vector_size(32)));
using Whole = std::int32_t __attribute__((vector_size(32)));
constexpr std::size_t kLanes = KernelGrid::kLanes;
static_assert(sizeof(Lanes) == kLanes * sizeof(float));

Lanes loaded(const float* from) {
    Lanes out;
    std::memcpy(&out, from, sizeof(out));
    return out;
}
void store(Lanes x, float* to) {
    std::memcpy(to, &x, sizeof(x));
}
Lanes all(float x) {
    return Lanes{} + x;
}
Lanes smallerOf(Lanes a, Lanes b) {
    return a < b ? a : b;
}
Lanes largerOf(Lanes a, Lanes b) {
    return a > b ? a : b;
}
Lanes absolute(Lanes x) {
    return largerOf(x, -x);
}
float largestIn(Lanes x) {
    float out = x[0];
    for (std::size_t i = 1; i < kLanes; ++i) out = out < x[i] ? x[i] : out;
    return out;
}

/// Returns log2 of normal, positive numbers, within 1e-6 (perceptual_quantizer.h).
Lanes logarithm(Lanes x) {
    constexpr std::int32_t kRootHalf = 0x3f3504f3;
    const auto bits = std::bit_cast<Whole>(x);
    const Whole exponent = (bits - kRootHalf) >> 23;
    const auto mantissa = std::bit_cast<Lanes>(bits - exponent * (1 << 23));
    const Lanes s = (mantissa - 1) / (mantissa + 1), square = s * s;
    const Lanes series = ((0.412198583f * square + 0.577078016f) * square + 0.961796694f) * square + 2.885390082f;
    return s * series + __builtin_convertvector(exponent, Lanes);
}
/// Returns 2^x of numbers in [-40, 40], within 3e-6 of it.
Lanes exponential(Lanes x) {
    const Whole floor = __builtin_convertvector(x + 64.5f, Whole) - 64;
    const Lanes rest = (x - __builtin_convertvector(floor, Lanes)) * std::numbers::ln2_v<float>;
    // Taylor's series up to |rest| <= 0.35: the term of degree 7 is 1.3e-7.
    const Lanes series =
        1 + rest * (1 + rest * (0.5f + rest * (1.0f / 6 + rest * (1.0f / 24 + rest * (1.0f / 120 + rest * (1.0f / 720))))));
    return std::bit_cast<Lanes>(std::bit_cast<Whole>(series) + floor * (1 << 23));
}

// The curve whose slope is 1 / q, q concave: PQ up to kBent, and beyond it that of q's line. The line has the least slope of q, which is
// 9.0507886 at 449.6 cd/m^2, less a little, so that it lies under q.
constexpr float kBent = 440, kBentQ = 4091.456f, kBentSlope = 9.0507f;
/// Rounding of the difference of two codes: twice 2e-7 of the polynomial, and of floats.
constexpr float kCodeRounding = 1.2e-6f;
/// Largest luminance of the curve [cd/m^2].
constexpr float kMostLuminance = 10000;

Lanes codeOf(Lanes nits) {
    constexpr float kMiddle = 2.64385619f;
    const Lanes within = smallerOf(nits, all(kBent));
    const Lanes u = (logarithm(within) - kMiddle) * kPerHalfRange;
    Lanes sum = all(kPerceptualQuantizer.back());
    for (std::size_t i = kPerceptualQuantizer.size() - 1; i > 0; --i) sum = sum * u + kPerceptualQuantizer[i - 1];
    // Nothing is added up to kBent.
    constexpr float kPerLogarithm = std::numbers::ln2_v<float> / kBentSlope;
    return sum + kPerLogarithm * logarithm(1 + kBentSlope / kBentQ * (largerOf(nits, all(kBent)) - kBent));
}
/// Returns an upper bound of the secant of that curve.
Lanes secantOf(Lanes x, Lanes y) {
    // Of close numbers the secant from a little below is as good, and has no cancellation.
    constexpr float kClose = 31.0f / 32;
    const Lanes high = largerOf(x, y), low = smallerOf(smallerOf(x, y), kClose * high);
    return (codeOf(high) - codeOf(low) + kCodeRounding) / (high - low);
}

/// Raises or lowers each number to those of the neighbours along an axis.
/// step  from one neighbour to the next
template <class Choose>
void passAlong(const float* from, float* to, std::size_t count, std::size_t length, std::size_t step, Choose choose) {
    for (std::size_t first = 0; first < count; first += length * step)
        for (std::size_t i = 0; i < length; ++i) {
            const float* here = from + first + i * step;
            const float *before = i > 0 ? here - step : here, *after = i + 1 < length ? here + step : here;
            for (std::size_t k = 0; k < step; k += kLanes)
                store(choose(choose(loaded(before + k), loaded(after + k)), loaded(here + k)), to + first + i * step + k);
        }
}
/// Replaces each number by the smallest or largest of its neighbours and itself.
template <class Choose>
void passToNeighbours(const KernelGrid& grid, float* plane, float* scratch, Choose choose) {
    const std::size_t count = grid.count(), round = grid.azimuths;
    // Azimuths are a circle. Rows are written with a copy of their last and first numbers on either side.
    std::array<float, 256> row;
    for (std::size_t first = 0; first < count; first += round) {
        float* here = plane + first;
        std::copy_n(here, round, row.data() + 1);
        row[0] = here[round - 1];
        row[round + 1] = here[0];
        for (std::size_t k = 0; k < round; k += kLanes)
            store(choose(choose(loaded(&row[k]), loaded(&row[k + 2])), loaded(&row[k + 1])), here + k);
    }
    passAlong(plane, scratch, count, grid.angles, round, choose);
    passAlong(scratch, plane, count, grid.shapes, round * grid.angles, choose);
}

/// A sum of three channels of which some may count with any number in [0, 1].
struct Clamped {
    std::array<Whole, 3> isClamped;  ///< -1 or 0
    /// Returns the largest absolute value of the sum of these terms.
    Lanes largest(const std::array<Lanes, 3>& terms) const {
        Lanes sure{}, above{}, below{};
        for (std::size_t c = 0; c < 3; ++c) {
            const Lanes term = terms[c];
            sure += isClamped[c] ? Lanes{} : term;
            const Lanes maybe = isClamped[c] ? term : Lanes{};
            above += largerOf(maybe, Lanes{});
            below += smallerOf(maybe, Lanes{});
        }
        return largerOf(sure + above, -(sure + below));
    }
};

ShDouble exitProfile(double angle) {
    ShDouble out = lighting::evaluateBasis(glm::dvec3(std::sin(angle), 0, std::cos(angle)));
    for (std::size_t i = 0; i < out.size(); ++i) out[i] *= lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[i])];
    return out;
}
/// Returns order^2 times the length of each band that an azimuth turns: that of its second derivative.
ShBands turningOf(const ShDouble& profile) {
    return {0, std::abs(profile[3]), std::hypot(profile[7], 4 * profile[8])};
}
void raise(ShBands& largest, const ShBands& lengths) {
    for (std::size_t l = 0; l < kBands; ++l) largest[l] = std::max(largest[l], lengths[l]);
}
double stepOf(std::size_t azimuths) {
    return 2 * std::numbers::pi / static_cast<double>(azimuths);
}

}  // namespace

void KernelGrid::addRow(const Row& profile, const ShBands& restOfRow, const ShBands& lengthsOfRow) {
    for (std::size_t k = 0; k < azimuths; ++k) {
        const double azimuth = stepOf(azimuths) * static_cast<double>(k), c = std::cos(azimuth), s = std::sin(azimuth);
        const double c2 = c * c - s * s, s2 = 2 * s * c;
        const ShDouble kernel = {profile[0],     s * profile[3], profile[2],     c * profile[3], s2 * profile[8],
                                 s * profile[7], profile[6],     c * profile[7], c2 * profile[8]};
        for (std::size_t i = 0; i < kernel.size(); ++i) kernels[i].push_back(static_cast<float>(kernel[i]));
        for (std::size_t l = 0; l < kBands; ++l) {
            rest[l].push_back(static_cast<float>(lightmap::kOutward * restOfRow[l]));
            lengths[l].push_back(static_cast<float>(lightmap::kOutward * lengthsOfRow[l]));
        }
    }
}

KernelGrid KernelGrid::diffuse(double tilt, int fineness) {
    const double degrees = fineness == 1 ? 20 : 8;
    KernelGrid grid;
    const double whole = tilt * std::numbers::pi / 180;
    const auto steps = static_cast<std::size_t>(std::ceil(tilt / degrees));
    grid.azimuths = steps == 0 ? kLanes : fineness == 1 ? 16 : 32;
    grid.angles = steps + 1;
    grid.shapes = 1;
    const double step = steps == 0 ? 0 : whole / static_cast<double>(steps), turn = stepOf(grid.azimuths);
    const ShBands lengths = lighting::bandLengths(exitProfile(0));
    std::vector<ShDouble> rows;
    for (std::size_t i = 0; i < grid.angles; ++i) rows.push_back(exitProfile(step * static_cast<double>(i)));
    for (std::size_t i = 0; i < grid.angles; ++i) {
        // A chord of a curve lies within an eighth of the squared step times the largest second derivative. Turns of a profile between two
        // rows are those of their mean and of what that lacks.
        ShBands turning = turningOf(rows[i]), rest{};
        if (i > 0) raise(turning, turningOf(rows[i - 1]));
        if (i + 1 < grid.angles) raise(turning, turningOf(rows[i + 1]));
        for (std::size_t l = 0; l < kBands; ++l) {
            const double order = static_cast<double>(l * l), along = order * lengths[l] * step * step / 8;
            rest[l] = along + turn * turn / 8 * (turning[l] + order * along);
        }
        grid.addRow(rows[i], rest, lengths);
    }
    return grid;
}

KernelGrid KernelGrid::specular(const LightMapShading& shading, const ScannedKernels& scanned, int fineness) {
    // Steps of the scanned kernels.
    const int viewStep = fineness == 1 ? 6 : 3, shapeStep = fineness == 1 ? 12 : 4;
    const auto range = std::ranges::minmax(shading.f0);
    const double lowF0 = range.min, highF0 = range.max;
    const auto stations = [](int count, int step) {
        std::vector<int> out;
        for (int i = 0; i < count - 1; i += step) out.push_back(i);
        out.push_back(count - 1);
        return out;
    };
    const std::vector<int> views = stations(ScannedKernels::kViews, viewStep), shapes = stations(scanned.roughnessCount(), shapeStep);
    KernelGrid grid;
    grid.azimuths = fineness == 1 ? 16 : 24;
    grid.angles = views.size();
    grid.shapes = shapes.size();
    grid.isDimmed = true;
    const double turn = stepOf(grid.azimuths);
    const auto rowAt = [&](std::size_t shape, std::size_t view) { return kernelAtF0(scanned.at(shapes[shape], views[view]), highF0); };
    std::vector<ShBands> rests(grid.angles * grid.shapes), lengths(grid.angles * grid.shapes);
    const auto distanceOf = [](const ShDouble& a, double factor, const ShDouble& b) {
        ShDouble out;
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = a[i] - factor * b[i];
        return lighting::bandLengths(out);
    };
    // Boxes of the grid, of one roughness if there is only one.
    const std::size_t lastShape = std::max<std::size_t>(grid.shapes, 2) - 1;
    for (std::size_t shape = 0; shape < lastShape; ++shape)
        for (std::size_t view = 0; view + 1 < grid.angles; ++view) {
            const std::size_t next = std::min(shape + 1, grid.shapes - 1);
            const std::array<ShDouble, 4> corners = {rowAt(shape, view), rowAt(shape, view + 1), rowAt(next, view), rowAt(next, view + 1)};
            ShBands lacking{}, longest{}, turning{};
            for (const ShDouble& corner : corners) raise(turning, turningOf(corner));
            for (int r = shapes[shape]; r <= shapes[next]; ++r)
                for (int v = views[view]; v <= views[view + 1]; ++v) {
                    const double x = static_cast<double>(v - views[view]) / (views[view + 1] - views[view]),
                                 y = next == shape ? 0 : static_cast<double>(r - shapes[shape]) / (shapes[next] - shapes[shape]);
                    ShDouble mean{};
                    for (std::size_t i = 0; i < mean.size(); ++i)
                        mean[i] =
                            (1 - y) * ((1 - x) * corners[0][i] + x * corners[1][i]) + y * ((1 - x) * corners[2][i] + x * corners[3][i]);
                    for (const double f0 : {lowF0, highF0}) {
                        const ShDouble kernel = kernelAtF0(scanned.at(r, v), f0);
                        double product = 0, square = 0;
                        for (std::size_t i = 0; i < mean.size(); ++i) {
                            product += kernel[i] * mean[i];
                            square += mean[i] * mean[i];
                        }
                        ShBands off = distanceOf(kernel, std::clamp(product / square, 0.0, 1.0), mean),
                                whole = lighting::bandLengths(kernel);
                        const ShBands between = scanned.between(r, v, f0);
                        for (std::size_t l = 0; l < kBands; ++l) {
                            off[l] += between[l];
                            whole[l] += between[l];
                        }
                        raise(lacking, off);
                        raise(longest, whole);
                    }
                }
            for (std::size_t l = 0; l < kBands; ++l) lacking[l] += turn * turn / 8 * turning[l];
            for (const std::size_t s : {shape, next})
                for (const std::size_t v : {view, view + 1}) {
                    raise(rests[s * grid.angles + v], lacking);
                    raise(lengths[s * grid.angles + v], longest);
                }
        }
    for (std::size_t shape = 0; shape < grid.shapes; ++shape)
        for (std::size_t view = 0; view < grid.angles; ++view)
            grid.addRow(rowAt(shape, view), rests[shape * grid.angles + view], lengths[shape * grid.angles + view]);
    return grid;
}

/// The bound of one light: planes of numbers for each control kernel.
class GridBound::Bounding {
public:
    Bounding(GridBound& owner, const KernelGrid& grid, const CellLight& light)
        : metric_(owner.metric_),
          anyLight_(owner.anyLight_),
          grid_(grid),
          light_(light),
          count_(grid_.count()),
          controls_(light.errors.count()),
          moves_(light.deviations.count()),
          planes_(owner.planes_),
          work_(owner.work_) {
        planes_.resize((kRings + kChannels * (2 * controls_ + moves_)) * count_);
        for (std::size_t c = 0; c < kChannels; ++c) {
            slacks_[c][0] = Slack(light.references.largest(c), light.referenceSlack[c]);
            slacks_[c][1] = Slack(light.errors.largest(c), light.errorSlack[c]);
            for (std::size_t l = 0; l < kBands; ++l)
                slacks_[c][1].ofRest[l] +=
                    static_cast<float>(lightmap::kOutward * static_cast<double>(moves_) * light.deviations.largest(c)[l]);
        }
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t c = 0; c < kChannels; ++c)
                lms_[row][c] = static_cast<float>(metric_.lms(static_cast<int>(row))[static_cast<int>(c)]);
        black_ = static_cast<float>(metric_.black());
    }

    /// Returns the bound of the errors, whatever the references are.
    double boundOfErrors() {
        addWork(controls_ + moves_);
        for (std::size_t j = 0; j < controls_; ++j) shade(light_.errors, j, error(j));
        for (std::size_t d = 0; d < moves_; ++d) shade(light_.deviations, d, deviation(d));
        findErrors();
        return anyLight_.bound(0, errorsWithin(0, count_));
    }
    double run(double threshold) {
        const double whatever = boundOfErrors();
        if (whatever < threshold) return whatever;
        for (std::size_t j = 0; j < controls_; ++j) shade(light_.references, j, reference(j));
        addWork(2 * controls_);
        // Kernels whose relative errors are small need no more, if those of their neighbours are small, too.
        const double enough = threshold - 2 * kVisibleRounding;
        const bool isAny =
            findLights(enough > 0 ? static_cast<float>(enough / (kFloats * VisibleMetric::largestStep() * kSteepestSlope)) : 0);
        if (!isAny) return threshold;
        for (std::size_t c = 0; c < kChannels; ++c) {
            spread(kDarkest + c, smallerOf);
            spread(kBrightest + c, largerOf);
            spread(kLeastError + c, smallerOf);
            spread(kMostError + c, largerOf);
        }
        spread(kIsOpen, largerOf);
        std::copy_n(ring(kIsOpen), count_, ring(kIsNeeded));
        spread(kIsNeeded, largerOf);
        addWork(4 * controls_);
        setOrder();
        for (std::size_t k = 0; k < count_; k += kLanes)
            if (isSet(kIsNeeded, k)) findRatios(k);
        if (!(largestIn(brightest_) <= kMostLuminance)) return std::min(whatever, metric_.mostVisible());
        for (std::size_t row = 0; row < 2; ++row) {
            spread(kLeastRatio + row, smallerOf);
            spread(kMostRatio + row, largerOf);
        }
        const Interval steep =
            VisibleMetric::steepnessBetween({-static_cast<double>(largestIn(-darkest_)), static_cast<double>(largestIn(brightest_))});
        steepness_ = {static_cast<float>(steep.low), static_cast<float>(steep.high)};
        double largest = threshold;
        for (std::size_t k = 0; k < count_; k += kLanes) {
            if (!isSet(kIsOpen, k) || anyLight_.bound(darkestWithin(k, k + kLanes), errorsWithin(k, k + kLanes)) <= largest) continue;
            const Lanes own = differencesOf(k);
            for (std::size_t i = 0; i < kLanes; ++i) {
                const double difference = VisibleMetric::roundedUp(kFloats * static_cast<double>(own[i]));
                if (difference <= largest) continue;
                largest = std::max(largest,
                                   std::min(difference, anyLight_.bound(darkestWithin(k + i, k + i + 1), errorsWithin(k + i, k + i + 1))));
            }
        }
        return std::min(largest, whatever);
    }

private:
    /// Planes of what a kernel has, or its neighbours.
    enum Ring : std::size_t {
        kDarkest = 0,  ///< by channel, of reference and of what is found
        kBrightest = 3,
        kLeastError = 6,
        kMostError = 9,
        kLeastRatio = 12,  ///< of M and S to L
        kMostRatio = 14,
        kIsOpen = 16,    ///< 1: must be bounded
        kIsNeeded = 17,  ///< 1: a neighbour must be
        kScratch = 18,
        kRings = 19
    };
    static constexpr double kFloats = 1 + 1e-4;  ///< covers relative errors of floats

    /// Factors of the kernels' lengths: what their rests, slacks and rounding add to a channel.
    struct Slack {
        std::array<float, kBands> ofRest{}, ofLength{};
        Slack() = default;
        Slack(const ShBands& largest, const ShBands& more) {
            for (std::size_t l = 0; l < kBands; ++l) {
                ofRest[l] = static_cast<float>(lightmap::kOutward * largest[l]);
                ofLength[l] = static_cast<float>(lightmap::kOutward * (more[l] + 2 * lightmap::kShadingRounding * largest[l]));
            }
        }
        Lanes at(const KernelGrid& grid, std::size_t k) const {
            Lanes sum{};
            for (std::size_t l = 0; l < kBands; ++l)
                sum += ofRest[l] * loaded(&grid.rest[l][k]) + ofLength[l] * loaded(&grid.lengths[l][k]);
            return sum;
        }
    };

    /// Counts work on so many vectors [cells of one control vector].
    void addWork(std::size_t vectors) {
        constexpr double kVectorsOfCell = 400;
        work_ += static_cast<double>(vectors * count_) / kVectorsOfCell;
    }
    float* ring(std::size_t which) { return planes_.data() + which * count_; }
    float* shaded(std::size_t vector, std::size_t c) { return planes_.data() + (kRings + vector * kChannels + c) * count_; }
    static std::size_t reference(std::size_t j) { return 2 * j; }
    static std::size_t error(std::size_t j) { return 2 * j + 1; }
    std::size_t deviation(std::size_t d) const { return 2 * controls_ + d; }
    Lanes at(std::size_t vector, std::size_t c, std::size_t k) { return loaded(shaded(vector, c) + k); }

    void shade(const LightVectors& from, std::size_t vector, std::size_t to) {
        std::array<std::array<float, kChannels>, lighting::kShCount> factors;
        std::array<const float*, lighting::kShCount> kernels;
        for (std::size_t i = 0; i < factors.size(); ++i) {
            kernels[i] = grid_.kernels[i].data();
            for (std::size_t c = 0; c < kChannels; ++c) factors[i][c] = static_cast<float>(from.value(vector, c, i));
        }
        float *const red = shaded(to, 0), *const green = shaded(to, 1), *const blue = shaded(to, 2);
        for (std::size_t k = 0; k < count_; k += kLanes) {
            const Lanes first = loaded(kernels[0] + k);
            Lanes r = factors[0][0] * first, g = factors[0][1] * first, b = factors[0][2] * first;
            for (std::size_t i = 1; i < factors.size(); ++i) {
                const Lanes kernel = loaded(kernels[i] + k);
                r += factors[i][0] * kernel;
                g += factors[i][1] * kernel;
                b += factors[i][2] * kernel;
            }
            store(r, red + k);
            store(g, green + k);
            store(b, blue + k);
        }
    }
    /// Returns what may be added to an error, and with the deviations of the sampler.
    std::array<Lanes, 2> slackOfError(std::size_t c, std::size_t k) {
        const Lanes slack = slacks_[c][1].at(grid_, k);
        Lanes moved = slack;
        for (std::size_t d = 0; d < moves_; ++d) moved += absolute(at(deviation(d), c, k));
        return {slack, moved};
    }
    void findErrors() {
        for (std::size_t c = 0; c < kChannels; ++c)
            for (std::size_t k = 0; k < count_; k += kLanes) {
                Lanes least = at(error(0), c, k), most = least;
                for (std::size_t j = 1; j < controls_; ++j) {
                    least = smallerOf(least, at(error(j), c, k));
                    most = largerOf(most, at(error(j), c, k));
                }
                const Lanes slack = slackOfError(c, k)[1];
                store(least - slack, ring(kLeastError + c) + k);
                store(most + slack, ring(kMostError + c) + k);
            }
    }
    Intervals errorsWithin(std::size_t first, std::size_t last) {
        Intervals out;
        for (std::size_t c = 0; c < kChannels; ++c)
            out[c] = {static_cast<double>(*std::min_element(ring(kLeastError + c) + first, ring(kLeastError + c) + last)),
                      static_cast<double>(*std::max_element(ring(kMostError + c) + first, ring(kMostError + c) + last))};
        return out;
    }
    double darkestWithin(std::size_t first, std::size_t last) {
        if (grid_.isDimmed) return 0;
        float out = std::numeric_limits<float>::max();
        for (std::size_t c = 0; c < kChannels; ++c)
            out = std::min(out, *std::min_element(ring(kDarkest + c) + first, ring(kDarkest + c) + last));
        return static_cast<double>(out);
    }
    /// Finds the darkest and the brightest lights, and the kernels whose difference relative to L, M or S is at least `share`. Returns true
    /// if there are any.
    bool findLights(float share) {
        Lanes any{};
        for (std::size_t k = 0; k < count_; k += kLanes) {
            std::array<Lanes, kChannels> ofReference, ofFound, low, high;
            for (std::size_t c = 0; c < kChannels; ++c) {
                ofReference[c] = slacks_[c][0].at(grid_, k);
                ofFound[c] = ofReference[c] + slackOfError(c, k)[1];
                low[c] = all(std::numeric_limits<float>::max());
                high[c] = -low[c];
            }
            Lanes isOpen{};
            for (std::size_t j = 0; j < controls_; ++j) {
                std::array<Lanes, 3> x{}, y{}, difference{};
                for (std::size_t c = 0; c < kChannels; ++c) {
                    const Lanes reference3 = at(reference(j), c, k), error3 = at(error(j), c, k), found = reference3 + error3;
                    const Lanes lowX = reference3 - ofReference[c], lowY = found - ofFound[c],
                                off = absolute(error3) + (ofFound[c] - ofReference[c]);
                    low[c] = smallerOf(low[c], smallerOf(lowX, lowY));
                    high[c] = largerOf(high[c], largerOf(reference3 + ofReference[c], found + ofFound[c]));
                    for (std::size_t row = 0; row < 3; ++row) {
                        x[row] += lms_[row][c] * lowX;
                        y[row] += lms_[row][c] * lowY;
                        difference[row] += lms_[row][c] * off;
                    }
                }
                for (std::size_t row = 0; row < 3; ++row)
                    isOpen = difference[row] < share * (black_ + smallerOf(x[row], y[row])) ? isOpen : all(1);
            }
            for (std::size_t c = 0; c < kChannels; ++c) {
                store(low[c], ring(kDarkest + c) + k);
                store(high[c], ring(kBrightest + c) + k);
            }
            store(isOpen, ring(kIsOpen) + k);
            any = largerOf(any, isOpen);
        }
        return largestIn(any) > 0;
    }
    bool isSet(Ring which, std::size_t k) { return largestIn(loaded(ring(which) + k)) > 0; }
    /// Replaces each number by the smallest or largest of its neighbours and itself.
    template <class Choose>
    void spread(std::size_t which, Choose choose) {
        passToNeighbours(grid_, ring(which), ring(kScratch), choose);
    }
    /// Sorts the channels by the ratios of M and of S to L.
    void setOrder() {
        for (std::size_t row = 1; row < 3; ++row) {
            std::array<std::size_t, 3>& order = order_[row - 1];
            order = {0, 1, 2};
            std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return lms_[row][a] * lms_[0][b] > lms_[row][b] * lms_[0][a]; });
            // The ratio of any light is between those of the channels and that of black.
            constexpr float kUp = 1 + 1e-5f;
            anyRatio_[row - 1] = {std::min(1.0f, lms_[row][order[2]] / lms_[0][order[2]]) / kUp,
                                  std::max(1.0f, lms_[row][order[0]] / lms_[0][order[0]]) * kUp};
        }
    }
    Clamped clampedAt(std::size_t k) {
        Clamped out;
        for (std::size_t c = 0; c < kChannels; ++c) out.isClamped[c] = loaded(ring(kDarkest + c) + k) < 0;
        return out;
    }
    /// Finds the ratios of M and S to L. A clamped channel may have anything from nothing to the most of its neighbours: a quotient of sums
    /// is largest with those channels whose own ratio is larger.
    void findRatios(std::size_t k) {
        const Clamped clamped = clampedAt(k);
        std::array<Lanes, kChannels> most;
        std::array<std::array<Lanes, 2>, kChannels> slack;
        for (std::size_t c = 0; c < kChannels; ++c) {
            most[c] = clamped.isClamped[c] ? largerOf(loaded(ring(kBrightest + c) + k), Lanes{}) : Lanes{};
            slack[c][0] = slacks_[c][0].at(grid_, k);
            slack[c][1] = slack[c][0] + slackOfError(c, k)[1];
        }
        std::array<Lanes, 2> low, high;
        low.fill(all(grid_.isDimmed ? 1 : std::numeric_limits<float>::max()));
        high.fill(all(grid_.isDimmed ? 1 : 0));
        for (std::size_t j = 0; j < controls_; ++j)
            for (std::size_t which = 0; which < 2; ++which) {
                std::array<Lanes, 3> least, brightest;
                least.fill(all(black_));
                brightest = least;
                for (std::size_t c = 0; c < kChannels; ++c) {
                    Lanes channel = at(reference(j), c, k);
                    if (which == 1) channel += at(error(j), c, k);
                    const Lanes lowest = clamped.isClamped[c] ? Lanes{} : largerOf(channel - slack[c][which], Lanes{}),
                                highest = clamped.isClamped[c] ? Lanes{} : channel + slack[c][which];
                    for (std::size_t row = 0; row < 3; ++row) {
                        least[row] += lms_[row][c] * lowest;
                        brightest[row] += lms_[row][c] * highest;
                    }
                }
                for (std::size_t row = 0; row < 3; ++row) {
                    darkest_ = smallerOf(darkest_, least[row]);
                    brightest_ =
                        largerOf(brightest_, brightest[row] + lms_[row][0] * most[0] + lms_[row][1] * most[1] + lms_[row][2] * most[2]);
                }
                for (std::size_t row = 1; row < 3; ++row) {
                    const auto& order = order_[row - 1];
                    const auto with = [&](std::size_t c, Lanes& over, Lanes& under, bool isLarger) {
                        const Lanes mine = lms_[row][c] * under, others = lms_[0][c] * over;
                        const Lanes more = (isLarger ? mine > others : mine < others) ? most[c] : Lanes{};
                        over += lms_[row][c] * more;
                        under += lms_[0][c] * more;
                    };
                    Lanes over = least[row], under = brightest[0];
                    for (std::size_t i = 3; i-- > 0;) with(order[i], over, under, false);
                    low[row - 1] = smallerOf(low[row - 1], over / under);
                    over = brightest[row];
                    under = least[0];
                    for (const std::size_t c : order) with(c, over, under, true);
                    high[row - 1] = largerOf(high[row - 1], over / under);
                }
            }
        for (std::size_t row = 0; row < 2; ++row) {
            store(largerOf(low[row], all(anyRatio_[row].first)), ring(kLeastRatio + row) + k);
            store(smallerOf(high[row], all(anyRatio_[row].second)), ring(kMostRatio + row) + k);
        }
    }
    /// Returns the bounds of kernels, each control against its own reference.
    Lanes differencesOf(std::size_t k) {
        const Clamped clamped = clampedAt(k);
        std::array<Lanes, 3> mean = {all(1), all(1), all(1)}, half = {};
        for (std::size_t row = 1; row < 3; ++row) {
            constexpr float kRounding = 1e-5f;
            const Lanes low = logarithm(loaded(ring(kLeastRatio + row - 1) + k)), high = logarithm(loaded(ring(kMostRatio + row - 1) + k));
            const auto [least, most] = steepness_;
            const Lanes highest = (1 + kRounding) * exponential(largerOf(-least * low, -most * low)),
                        lowest = (1 - kRounding) * exponential(smallerOf(-least * high, -most * high));
            mean[row] = 0.5f * (highest + lowest);
            half[row] = 0.5f * (highest - lowest);
        }
        // Weights of the channels in I, T and P at the mean secants, and in L, M and S.
        using Weights = std::array<std::array<Lanes, kChannels>, 3>;
        Weights itp, nits;
        std::array<std::array<float, 3>, 3> sizes;
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t c = 0; c < kChannels; ++c) {
                itp[row][c] = Lanes{};
                nits[row][c] = all(lms_[row][c]);
                for (std::size_t i = 0; i < 3; ++i)
                    itp[row][c] +=
                        static_cast<float>(VisibleMetric::itp(static_cast<int>(row))[static_cast<int>(i)]) * lms_[i][c] * mean[i];
                sizes[row][c] = std::abs(static_cast<float>(VisibleMetric::itp(static_cast<int>(row))[static_cast<int>(c)]));
            }
        const auto largest = [&](const std::array<Lanes, kChannels>& weights, std::size_t vector) {
            return clamped.largest({weights[0] * at(vector, 0, k), weights[1] * at(vector, 1, k), weights[2] * at(vector, 2, k)});
        };
        // What the sampler and all slacks add.
        std::array<Lanes, 3> ofItp{}, ofNits{};
        std::array<std::array<Lanes, 2>, kChannels> slack;
        for (std::size_t c = 0; c < kChannels; ++c) {
            const auto [alone, moved] = slackOfError(c, k);
            slack[c][0] = slacks_[c][0].at(grid_, k);
            slack[c][1] = slack[c][0] + moved;
            for (std::size_t row = 0; row < 3; ++row) {
                ofItp[row] += absolute(itp[row][c]) * alone;
                ofNits[row] += lms_[row][c] * alone;
            }
        }
        for (std::size_t d = 0; d < moves_; ++d)
            for (std::size_t row = 0; row < 3; ++row) {
                ofItp[row] += largest(itp[row], deviation(d));
                ofNits[row] += largest(nits[row], deviation(d));
            }
        Lanes out{};
        for (std::size_t j = 0; j < controls_; ++j) {
            Lanes x = all(black_), y = x;
            for (std::size_t c = 0; c < kChannels; ++c) {
                const Lanes channel = at(reference(j), c, k), found = channel + at(error(j), c, k);
                x += clamped.isClamped[c] ? Lanes{} : lms_[0][c] * largerOf(channel - slack[c][0], Lanes{});
                y += clamped.isClamped[c] ? Lanes{} : lms_[0][c] * largerOf(found - slack[c][1], Lanes{});
            }
            std::array<Lanes, 3> rest{};
            for (std::size_t i = 1; i < 3; ++i) rest[i] = half[i] * (largest(nits[i], error(j)) + ofNits[i]);
            Lanes squares{};
            for (std::size_t row = 0; row < 3; ++row) {
                const Lanes each = largest(itp[row], error(j)) + ofItp[row] + sizes[row][1] * rest[1] + sizes[row][2] * rest[2];
                squares += each * each;
            }
            const Lanes secant = secantOf(x, y), square = squares * secant * secant;
            // NaN stays.
            out = square <= out ? out : square;
        }
        for (std::size_t i = 0; i < kLanes; ++i) out[i] = std::sqrt(out[i]);
        return out;
    }

    const VisibleMetric& metric_;
    const AnyLightBound& anyLight_;
    const KernelGrid& grid_;
    const CellLight& light_;
    std::size_t count_, controls_, moves_;
    std::vector<float>& planes_;
    double& work_;
    std::array<std::array<Slack, 2>, kChannels> slacks_;  ///< [channel] of reference and error
    std::array<std::array<float, kChannels>, 3> lms_;
    std::array<std::array<std::size_t, kChannels>, 2> order_{};
    std::array<std::pair<float, float>, 2> anyRatio_{};
    float black_;
    Lanes darkest_ = all(std::numeric_limits<float>::max()), brightest_{};
    std::pair<float, float> steepness_;
};

double GridBound::bound(const CellLight& light, double threshold, bool isFine) {
    if (!light.isFinite || !metric_.isPositive() || light.directions.count() > 0) return kUnbounded;
    // The vectors cost work before they come here.
    work_ = 2 * static_cast<double>(light.errors.count() + light.deviations.count());
    return Bounding(*this, isFine ? grids_.fine : grids_.coarse, light).run(threshold);
}

}  // namespace lightcook::verify
