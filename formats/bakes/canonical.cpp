#include "formats/bakes/canonical.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <optional>
#include <utility>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;

/// Name of a coefficient in errors of files that do not store it: "sh03.G".
std::string coefficientName(std::size_t index, int channel) {
    return fmt::format("sh{:02}.{}", index, "RGB"[channel]);
}

bool isFinite(const ShRgb& sh) {
    bool finite = true;
    for (const glm::vec3& coefficient : sh) {
        for (int channel = 0; channel < 3; ++channel) finite &= std::isfinite(coefficient[channel]);
    }
    return finite;
}

/// Returns the coefficient and the colour of the largest number, the first of several.
/// coefficientCount  of the coefficients that are looked at, from 0 on
std::pair<std::size_t, int> largestOf(const ShRgb& sh, std::size_t coefficientCount) {
    std::pair<std::size_t, int> largest(0, 0);
    for (std::size_t i = 0; i < coefficientCount; ++i)
        for (int channel = 0; channel < 3; ++channel)
            if (std::abs(sh[i][channel]) > std::abs(sh[largest.first][largest.second])) largest = {i, channel};
    return largest;
}

/// Returns the largest finite sh00, or 0.
float brightestOf(const ImageView<const ShRgb>& row) {
    float brightest = 0;
    for (int x = 0; x < row.width; ++x)
        for (int channel = 0; channel < 3; ++channel)
            if (const float light = row.at(x, 0)[0][channel]; light > brightest && std::isfinite(light)) brightest = light;
    return brightest;
}

std::string notFinite(float value) {
    return fmt::format("found {}, expected a finite value", value);
}

}  // namespace

CanonicalConversion::CanonicalConversion(const LightMapDescription& description, const LinearConversion& colors)
    : flipsPhase_(description.phase == ShPhase::CondonShortley),
      rotates_(description.frame == ShFrame::Tangent),
      convertsColor_(!colors.isIdentity),
      workingFromSource_(colors.workingFromSource),
      fileFromMesh_(description.axes.inverse()) {
    if (!description.axes.isIdentity()) axes_.emplace(description.axes.matrix());
    for (std::size_t band = 0; band < bandFactors_.size(); ++band) {
        if (description.quantity == ShQuantity::Irradiance) bandFactors_[band] /= lighting::kIrradianceBands[band];
        if (description.lightUnits == LightUnits::Game) bandFactors_[band] *= std::numbers::pi;
    }
    scales_ = bandFactors_ != lighting::ShBands{1.0, 1.0, 1.0};
}

float CanonicalConversion::longestBand(std::size_t degree) const {
    return static_cast<float>(std::sqrt(2.0 * static_cast<double>(degree) + 1) * bandFactors_[0] / bandFactors_[degree]);
}

ShRgb CanonicalConversion::operator()(ShRgb sh, const glm::vec3& normal) const {
    if (flipsPhase_) sh = lighting::flipCondonShortley(sh);
    if (scales_) sh = lighting::convolve(sh, bandFactors_);
    // The tangent frame is that of the normal as the file has it.
    if (rotates_) sh = lighting::ShRotation(lighting::worldFromTangentFrame(glm::normalize(fileFromMesh_(glm::dvec3(normal))))).apply(sh);
    if (axes_) sh = axes_->apply(sh);
    if (convertsColor_) {
        for (glm::vec3& coefficient : sh) coefficient = workingFromSource_ * coefficient;
    }
    return sh;
}

tl::unexpected<Error> Canonicalizer::refuse(ErrorCode code, const std::string& channel, int x, int y, std::string detail) const {
    return failure(code, file_.at(fmt::format("channel {}, texel ({}, {})", channel, x, y)), std::move(detail));
}

StoredNumber Canonicalizer::placeOf(std::size_t coefficient, int colour, int x, int y, const BakeReader& reader) const {
    return reader.placeOf(coefficient, colour, x, y).value_or(StoredNumber{file_, coefficientName(coefficient, colour), x, y});
}

/// Returns the place of a run of numbers, by its first and its last.
Subject placeOfRun(const StoredNumber& first, const StoredNumber& last) {
    const auto texel = [](const StoredNumber& number) { return fmt::format("texel ({}, {})", number.x, number.y); };
    const bool isOneTexel = first.file.text == last.file.text && texel(first) == texel(last);
    if (!isOneTexel)
        return first.file.at(
            fmt::format("channel {}, {} .. {}, channel {}, {}", first.channel, texel(first), last.file.text, last.channel, texel(last)));
    const std::string channels = first.channel == last.channel ? first.channel : first.channel + " .. " + last.channel;
    return first.file.at(fmt::format("channel {}, {}", channels, texel(first)));
}

tl::unexpected<Error> Canonicalizer::refuseNumber(ErrorCode code, std::size_t coefficient, int colour, int x, int y, float value,
                                                  const std::string& expected, const BakeReader& reader) const {
    const StoredNumber place = placeOf(coefficient, colour, x, y, reader);
    // A finite number may become infinite where it is decoded.
    const bool isAtFault = place.value && (std::isfinite(value) || !std::isfinite(*place.value));
    return failure(code, placeOfRun(place, place), fmt::format("found {}, expected {}", isAtFault ? *place.value : value, expected));
}

Subject Canonicalizer::nameOf(std::size_t coefficient, int colour, int x, int y, const BakeReader& reader) const {
    const StoredNumber place = placeOf(coefficient, colour, x, y, reader);
    return placeOfRun(place, place);
}

/// Lengths of normals that a baker's filter may leave, and more than rounding does.
constexpr double kShortNormal = 0.8, kLongNormal = 1.25;

/// Returns true for a normal that is no unit vector, but is one as a colour: n = (unit + 1) / 2.
bool isEncodedNormal(const glm::vec3& normal) {
    constexpr double kTolerance = 0.03;  // of 8 bits
    const auto isUnit = [&](const glm::dvec3& vector) { return std::abs(glm::length(vector) - 1) <= kTolerance; };
    return !isUnit(glm::dvec3(normal)) && isUnit(2.0 * glm::dvec3(normal) - 1.0);
}

/// Returns true if texel (x, y) of the strip lies inside a chart, and stores its normal then.
Result<bool> Canonicalizer::isCovered(const RawStrip& raw, int x, int y, LightMapStrip& strip, const BakeReader& reader) const {
    if (raw.coverage.width() > 0) {
        const float coverage = raw.coverage.at(x, y);
        if (!std::isfinite(coverage)) {
            if (!repairs_) return refuse(ErrorCode::ValueNotFinite, reader.coverageChannel(), x, strip.firstRow + y, notFinite(coverage));
            ++strip.repairs.notFinite;
            return false;
        }
        strip.coverage.smallest = std::min(strip.coverage.smallest, coverage);
        strip.coverage.largest = std::max(strip.coverage.largest, coverage);
        if (!(coverage > 0.5f)) return false;
    }
    ++strip.coverage.inside;
    if (raw.normal.width() == 0) return true;
    const glm::vec3 normal = raw.normal.at(x, y);
    for (int axis = 0; axis < 3; ++axis) {
        if (std::isfinite(normal[axis])) continue;
        if (!repairs_)
            return refuse(ErrorCode::ValueNotFinite, fmt::format("normal.{}", "XYZ"[axis]), x, strip.firstRow + y, notFinite(normal[axis]));
        ++strip.repairs.notFinite;
        return false;
    }
    const double length = glm::length(glm::dvec3(normal));
    strip.coverage.oddNormals += length < kShortNormal || length > kLongNormal ? 1 : 0;
    strip.coverage.encodedNormals += isEncodedNormal(normal) ? 1 : 0;
    if (length <= 0.5) {  // bakers write zero where they have no surface
        ++strip.coverage.withoutNormal;
        return false;
    }
    strip.normal.at(x, y) = glm::vec3(normalAxes_(glm::dvec3(normal) / length));
    return true;
}

/// Returns the chart of texel (x, y) of the strip.
Result<std::uint32_t> Canonicalizer::chartAt(const RawStrip& raw, int x, int y, const LightMapStrip& strip) const {
    constexpr float kEnd = 0x1p24f;  // floats count no further
    const float chart = raw.chart.at(x, y);
    if (chart >= 0 && chart < kEnd && chart == std::floor(chart)) {
        if (chart > 0) return static_cast<std::uint32_t>(chart);
        if (strip.covered.at(x, y) == 0) return kNoChart;
    }
    return refuse(ErrorCode::ValueOutOfRange, "chart.Y", x, strip.firstRow + y,
                  fmt::format("found {}, expected the number of a chart, from 1 on, or 0 where the texel is outside charts", chart));
}

/// Refuses colours of a texel that are computed from a negative number (RawStrip::negative), or counts them: the number was taken as 0.
Result<void> Canonicalizer::checkStored(std::uint8_t negative, int x, int y, LightMapStrip& strip, const BakeReader& reader) const {
    for (int channel = 0; channel < 3; ++channel) {
        if ((negative >> channel & 1) == 0) continue;
        if (!repairs_) return refuseNumber(ErrorCode::ValueOutOfRange, 0, channel, x, strip.firstRow + y, -1, "no negative energy", reader);
        ++strip.repairs.negativeDc;
    }
    return {};
}

/// Replaces infinite light, an overflow of the baker's halves, by the largest half. Coefficients 1 to 8 of that channel become 0.
void limitInfiniteLight(ShRgb& sh) {
    constexpr float kLargestHalf = 65504;
    for (int channel = 0; channel < 3; ++channel) {
        if (!(sh[0][channel] > std::numeric_limits<float>::max())) continue;
        for (glm::vec3& coefficient : sh) coefficient[channel] = 0;
        sh[0][channel] = kLargestHalf;
    }
}

/// Refuses coefficients that no light has, or repairs and counts them.
/// brightest   largest sh00 of the row
Result<void> Canonicalizer::checkTexel(ShRgb& sh, int x, int y, float brightest, LightMapStrip& strip, const BakeReader& reader) const {
    if (sh == ShRgb{}) return {};
    if (!isFinite(sh)) {
        if (repairs_) {
            ++strip.repairs.notFinite;
            if (!isCompressed_) limitInfiniteLight(sh);
            if (!isFinite(sh)) sh = ShRgb{};
            if (isCompressed_) return {};
        }
        for (std::size_t i = 0; i < sh.size(); ++i)
            for (int channel = 0; channel < 3; ++channel)
                if (!std::isfinite(sh[i][channel]))
                    return refuseNumber(ErrorCode::ValueNotFinite, i, channel, x, strip.firstRow + y, sh[i][channel], "a finite value",
                                        reader);
    }
    if (isCompressed_) return {};
    for (int channel = 0; channel < 3; ++channel) {
        if (!(sh[0][channel] < 0)) continue;
        if (!repairs_)
            return refuseNumber(ErrorCode::ValueOutOfRange, 0, channel, x, strip.firstRow + y, sh[0][channel], "no negative energy",
                                reader);
        ++strip.repairs.negativeDc;
        for (glm::vec3& coefficient : sh) coefficient[channel] = 0;
    }
    return checkBandLengths(sh, x, y, brightest, strip, reader);
}

/// Compares the length of bands 1 and 2 with the most that light of this sh00 can have. Windowing, rotation and rounding to halves (whose
/// smallest step is 6e-8) go a little beyond it; four times as much means another bake format, sign convention or unit. Light may have been
/// brought to larger units after it was rounded, so that the step grows with the brightest light.
Result<void> Canonicalizer::checkBandLengths(ShRgb& sh, int x, int y, float brightest, LightMapStrip& strip,
                                             const BakeReader& reader) const {
    constexpr float kAllowance = 4;
    const float rounding = 1e-6f * std::max(brightest, 1.0f);
    std::array<glm::dvec3, 3> squares{};  // [band]
    for (std::size_t i = 1; i < sh.size(); ++i)
        squares[static_cast<std::size_t>(lighting::kShBand[i])] += glm::dvec3(sh[i]) * glm::dvec3(sh[i]);
    for (int channel = 0; channel < 3; ++channel)
        for (const std::size_t degree : {1u, 2u}) {
            const std::size_t first = degree * degree, end = first + 2 * degree + 1;
            const double longest = longestBands_[degree] * sh[0][channel], most = kAllowance * longest + rounding;
            if (squares[degree][channel] <= most * most) continue;
            const double length = std::sqrt(squares[degree][channel]);
            if (!repairs_)
                return failure(ErrorCode::ValueOutOfRange,
                               placeOfRun(placeOf(first, channel, x, strip.firstRow + y, reader),
                                          placeOf(end - 1, channel, x, strip.firstRow + y, reader)),
                               fmt::format("found a length of {:.7g}, expected at most {:.7g}: {} times what light with sh00 of {} has",
                                           length, kAllowance * longest, kAllowance, sh[0][channel]));
            ++strip.repairs.bandsBeyond;
            for (std::size_t i = first; i < end; ++i) sh[i][channel] = static_cast<float>(sh[i][channel] * (longest / length));
        }
    return {};
}

Result<void> Canonicalizer::convert(ShRgb& sh, int x, int y, LightMapStrip& strip, const BakeReader& reader) const {
    const ShRgb converted = conversion_(sh, strip.normal.at(x, y));
    if (!isFinite(converted)) {
        // Other coefficients may be computed from the numbers of the first.
        const glm::vec3& first = converted[0];
        const bool isFirst = !std::isfinite(first.x) || !std::isfinite(first.y) || !std::isfinite(first.z);
        const auto [coefficient, colour] = largestOf(sh, isFirst ? 1 : sh.size());
        return failure(ErrorCode::ValueOutOfRange, nameOf(coefficient, colour, x, strip.firstRow + y, reader),
                       "found light that leaves the range of float when brought to canonical units, expected less than 1e38");
    }
    sh = converted;
    if (conversion_.convertsColor()) {
        for (int channel = 0; channel < 3; ++channel) strip.negativeAfterGamut += sh[0][channel] < 0 ? 1 : 0;
    }
    return {};
}

Result<LightMapStrip> Canonicalizer::operator()(RawStrip raw, int firstRow, const BakeReader& reader) const {
    const int width = raw.sh.width(), height = raw.sh.height();
    LightMapStrip strip;
    strip.firstRow = firstRow;
    strip.covered = Image<std::uint8_t>(width, height, 0);
    strip.normal = Image<glm::vec3>(width, height, glm::vec3(0, 0, 1));
    const bool hasCharts = raw.chart.width() > 0;
    if (hasCharts) strip.chart = Image<std::uint32_t>(width, height);
    for (int y = 0; y < height; ++y) {
        const float brightest = brightestOf(std::as_const(raw.sh).view().rows(y, 1));
        for (int x = 0; x < width; ++x) {
            ShRgb& sh = raw.sh.at(x, y);
            const Result<bool> covered = isCovered(raw, x, y, strip, reader);
            if (!covered) return tl::make_unexpected(covered.error());
            strip.covered.at(x, y) = *covered ? 1 : 0;
            if (hasCharts) {
                LC_TRY(chart, chartAt(raw, x, y, strip));
                strip.chart.at(x, y) = *chart;
            }
            if (!*covered) {
                sh = ShRgb{};
                continue;
            }
            LC_CHECK(checkTexel(sh, x, y, brightest, strip, reader));
            if (raw.negative.width() > 0) LC_CHECK(checkStored(raw.negative.at(x, y), x, y, strip, reader));
            if (!conversion_.isIdentity()) LC_CHECK(convert(sh, x, y, strip, reader));
            if (!output_) continue;
            sh = output_->apply(sh);
            strip.normal.at(x, y) = glm::vec3(outputAxes_(glm::dvec3(strip.normal.at(x, y))));
        }
    }
    strip.sh = std::move(raw.sh);
    strip.tangent = std::move(raw.tangent);
    return strip;
}

}  // namespace lightcook::formats
