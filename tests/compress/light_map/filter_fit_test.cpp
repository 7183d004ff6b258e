#include "compress/light_map/filter_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/compress/light_map/synthetic_plan.h"

namespace lightcook {
namespace {

using compress::rows::Source;
using formats::LightMapLayout;
using formats::Target;
using synthetic::kHeight;
using synthetic::Kind;
using synthetic::kWidth;

/// Sums, over places of the surface whose filter reaches texels outside charts, of the squared error of coefficient 0 over the light there.
/// Places lie on a grid of 8 x 8 for each quad, and each belongs to its nearest texel.
/// isProduct  the other coefficients are products of a filtered coefficient 0 and filtered ratios; coefficient 3 is measured
double rimError(const formats::LightMapStrip& strip, const Source& source, double floor, bool isProduct) {
    constexpr int kPlaces = 8;
    double sum = 0;
    for (int y = 0; y + 1 < kHeight; ++y)
        for (int x = 0; x + 1 < kWidth; ++x) {
            std::array<bool, 4> covered{};
            for (int k = 0; k < 4; ++k) covered[static_cast<std::size_t>(k)] = strip.covered.at(x + k % 2, y + k / 2) != 0;
            if (std::ranges::count(covered, true) % 4 == 0) continue;
            for (int place = 0; place < kPlaces * kPlaces; ++place) {
                const int column = place % kPlaces, row = place / kPlaces;
                const double px = (column + 0.5) / kPlaces, py = (row + 0.5) / kPlaces;
                if (!covered[static_cast<std::size_t>((px > 0.5 ? 1 : 0) + (py > 0.5 ? 2 : 0))]) continue;
                double weights = 0, reference = 0, light = 0, dc = 0, other = 0;
                for (int k = 0; k < 4; ++k) {
                    const double w = (k % 2 == 0 ? 1 - px : px) * (k / 2 == 0 ? 1 - py : py);
                    const auto zero = static_cast<double>(source.values[0].at(x + k % 2, y + k / 2).y);
                    const auto third = static_cast<double>(source.values[3].at(x + k % 2, y + k / 2).y);
                    dc += w * zero;
                    other += w * (isProduct ? third / zero : zero);
                    if (!covered[static_cast<std::size_t>(k)]) continue;
                    weights += w;
                    reference += w * (isProduct ? third : zero);
                    light += w * zero;
                }
                const double error = ((isProduct ? dc : 1) * other - reference / weights) / (0.282 * light / weights + floor);
                sum += error * error;
            }
        }
    return sum;
}

struct Padded {
    compress::LightMapPlan plan;
    formats::LightMapStrip strip;
    Source mean, solved;
};
Padded padded(Kind kind, LightMapLayout layout) {
    Padded out{synthetic::planOf(kind, layout, Target::Bc), synthetic::makeBand(kind, kWidth, 0, kHeight), {}, {}};
    out.mean = compress::rows::makeSource(out.plan, out.strip, 0, kHeight);
    out.solved = compress::rows::makeSource(out.plan, out.strip, 0, kHeight);
    compress::rows::fitToFilter(out.plan, out.strip, 0, out.solved);
    return out;
}

TEST(SolvedRims, ShowTheLightOfTheSurface) {
    const Padded linear = padded(Kind::Gradient, LightMapLayout::Hdr), product = padded(Kind::Gradient, LightMapLayout::Ratio);
    const double floor = 0.05 * linear.plan.key;
    EXPECT_LT(rimError(linear.strip, linear.solved, floor, false), 0.1 * rimError(linear.strip, linear.mean, floor, false));
    EXPECT_LT(rimError(product.strip, product.solved, floor, true), 0.2 * rimError(product.strip, product.mean, floor, true));
}

/// Least squares: to move one padded texel makes the sum larger, or less than 1 % smaller.
TEST(SolvedRims, AreAtTheLeastSum) {
    Padded padding = padded(Kind::Gradient, LightMapLayout::Raw);
    const double floor = 0.05 * padding.plan.key, least = rimError(padding.strip, padding.solved, floor, false);
    for (int y = 10; y < 14; ++y)
        for (int x = 15; x < 22; ++x) {
            if (padding.strip.covered.at(x, y) != 0) continue;
            glm::vec3& dc = padding.solved.values[0].at(x, y);
            for (const float factor : {0.9f, 0.98f, 1.02f, 1.1f}) {
                const glm::vec3 before = dc;
                dc *= factor;
                EXPECT_GT(rimError(padding.strip, padding.solved, floor, false), 0.99 * least) << x << ", " << y << ", " << factor;
                dc = before;
            }
        }
}

/// A straight rim: the texels beyond it repeat the outermost ones.
TEST(SolvedRims, RepeatTheTexelsOfAStraightRim) {
    const Padded padding = padded(Kind::Gradient, LightMapLayout::Raw);
    for (int y = 3; y < 8; ++y)
        for (std::size_t i = 0; i < lighting::kShCount; ++i)
            for (int c = 0; c < 3; ++c) {
                const float rim = padding.strip.sh.at(16, y)[i][c];
                EXPECT_NEAR(padding.solved.values[i].at(17, y)[c], rim, 0.02f * (std::abs(rim) + padding.strip.sh.at(16, y)[0][c]));
            }
}

TEST(SolvedRims, ChangeNothingElse) {
    for (const LightMapLayout layout : {LightMapLayout::Raw, LightMapLayout::Flat, LightMapLayout::Ratio}) {
        const Padded padding = padded(Kind::Gradient, layout);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                if (padding.mean.coverage.at(x, y) == 0x1p-8f) continue;
                EXPECT_EQ(padding.solved.coverage.at(x, y), padding.mean.coverage.at(x, y));
                for (std::size_t i = 0; i < padding.mean.values.size(); ++i)
                    EXPECT_EQ(padding.solved.values[i].at(x, y), padding.mean.values[i].at(x, y));
            }
    }
}

/// The strip's chart is 1 inside and at `beyond` outside.
formats::Image<std::uint32_t> chartsOf(const formats::LightMapStrip& strip, std::uint32_t beyond) {
    formats::Image<std::uint32_t> charts(kWidth, kHeight, 1);
    for (std::size_t i = 0; i < charts.texels().size(); ++i)
        if (strip.covered.texels()[i] == 0) charts.texels()[i] = beyond;
    return charts;
}

TEST(SolvedRims, AreThoseThatASurfaceReads) {
    Padded padding = padded(Kind::Gradient, LightMapLayout::Ratio);
    const auto solvedWith = [&](std::uint32_t beyond) {
        padding.strip.chart = chartsOf(padding.strip, beyond);
        Source source = compress::rows::makeSource(padding.plan, padding.strip, 0, kHeight);
        compress::rows::fitToFilter(padding.plan, padding.strip, 0, source);
        return source;
    };
    const Source read = solvedWith(1), unread = solvedWith(formats::kNoChart);
    for (std::size_t i = 0; i < read.values.size(); ++i) {
        EXPECT_EQ(read.values[i].texels(), padding.solved.values[i].texels());
        EXPECT_EQ(unread.values[i].texels(), padding.mean.values[i].texels());
    }
    EXPECT_EQ(unread.coverage.texels(), padding.mean.coverage.texels());
    EXPECT_NE(read.values[0].texels(), unread.values[0].texels());
}

/// Sums, over 8 x 8 places of each quad of covered texels, of the squared error of coefficient 3, as the product of filtered factors, over
/// the light there.
double productError(const formats::LightMapStrip& strip, const Source& source, double floor) {
    constexpr int kPlaces = 8;
    double sum = 0;
    for (int y = 0; y + 1 < kHeight; ++y)
        for (int x = 0; x + 1 < kWidth; ++x) {
            bool isInside = true;
            for (int k = 0; k < 4; ++k) isInside = isInside && strip.covered.at(x + k % 2, y + k / 2) != 0;
            for (int place = 0; isInside && place < kPlaces * kPlaces; ++place) {
                const int column = place % kPlaces, row = place / kPlaces;
                const double px = (column + 0.5) / kPlaces, py = (row + 0.5) / kPlaces;
                double light = 0, ratio = 0, reference = 0;
                for (int k = 0; k < 4; ++k) {
                    const double w = (k % 2 == 0 ? 1 - px : px) * (k / 2 == 0 ? 1 - py : py);
                    const auto dc = static_cast<double>(source.values[0].at(x + k % 2, y + k / 2).y);
                    light += w * dc;
                    ratio += w * static_cast<double>(source.values[3].at(x + k % 2, y + k / 2).y) / dc;
                    reference += w * static_cast<double>(strip.sh.at(x + k % 2, y + k / 2)[3].y);
                }
                const double error = (light * ratio - reference) / (0.282 * light + floor);
                sum += error * error;
            }
        }
    return sum;
}

/// A map with an edge of light along a column, at which the direction of the light turns.
formats::LightMapStrip edge() {
    formats::LightMapStrip strip = synthetic::makeBand(Kind::Grey, kWidth, 0, kHeight);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            auto& sh = strip.sh.at(x, y);
            const bool isBright = x > 8 + y / 3;
            for (std::size_t i = 1; i < sh.size(); ++i) sh[i] = (isBright ? 0.3f : -0.2f) * sh[0];
            if (isBright)
                for (glm::vec3& coefficient : sh) coefficient *= 30.0f;
        }
    return strip;
}

Source fitted(const compress::LightMapPlan& plan, const formats::LightMapStrip& strip, int firstRow, int rowCount) {
    Source source = compress::rows::makeSource(plan, strip, firstRow, rowCount);
    compress::rows::fitToFilter(plan, strip, firstRow, source);
    return source;
}

void expectLessErrorAtEdges(LightMapLayout layout) {
    const formats::LightMapStrip strip = edge();
    compress::LightMapPlan plan = synthetic::planOf(layout, Target::Bc, strip, synthetic::fast());
    plan.objective.reset();
    const Source own = fitted(plan, strip, 0, kHeight);
    for (std::size_t i = 0; i < own.values.size(); ++i)
        for (int x = 0; x < kWidth; ++x) EXPECT_EQ(own.values[i].at(x, 5), strip.sh.at(x, 5)[i]) << "under energy texels keep their own";
    plan.objective.emplace();
    const Source found = fitted(plan, strip, 0, kHeight);
    const double floor = 0.05 * plan.key;
    EXPECT_LT(productError(strip, found, floor), 0.6 * productError(strip, own, floor));
    int moved = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            EXPECT_EQ(found.values[0].at(x, y), own.values[0].at(x, y));
            EXPECT_EQ(found.coverage.at(x, y), own.coverage.at(x, y));
            const bool isMoved = found.values[3].at(x, y) != own.values[3].at(x, y);
            moved += isMoved ? 1 : 0;
            if (std::abs(x - 8 - y / 3) > 3) {
                EXPECT_FALSE(isMoved) << x << ", " << y << ": no edge is near";
            }
        }
    EXPECT_GT(moved, kHeight);
}

TEST(FittedRatios, OfRatioErrLessBetweenTexelsAtEdgesOfLight) {
    expectLessErrorAtEdges(LightMapLayout::Ratio);
}

TEST(FittedRatios, OfALearnedLayoutErrLessBetweenTexelsAtEdgesOfLight) {
    expectLessErrorAtEdges(LightMapLayout::Basis8);
}

TEST(FittedRatios, AreTheSameWhateverTheCutOfTheMap) {
    constexpr int kStrip = 16, kContext = compress::kLightMapContextRows;
    for (const Kind kind : {Kind::Gradient, Kind::Spikes}) {
        const formats::LightMapStrip whole = synthetic::makeBand(kind, kWidth, 0, 3 * kStrip);
        compress::LightMapPlan plan = synthetic::planOf(LightMapLayout::Ratio, Target::Bc, whole, {});
        plan.objective.emplace();
        const Source all = fitted(plan, whole, 0, 3 * kStrip);
        const Source part =
            fitted(plan, synthetic::makeBandWithContext(kind, kWidth, 3 * kStrip, kStrip, kStrip, kContext), kStrip, kStrip);
        for (std::size_t i = 0; i < all.values.size(); ++i)
            for (int y = 0; y < kStrip; ++y)
                for (int x = 0; x < kWidth; ++x)
                    ASSERT_EQ(part.values[i].at(x, y), all.values[i].at(x, kStrip + y)) << i << ", " << x << ", " << y;
    }
}

/// Formats without sign hold no negative light, and no ratio below the bias.
TEST(SolvedRims, StayWithinTheLayout) {
    for (const Kind kind : {Kind::Gradient, Kind::Spikes, Kind::NegativeBands, Kind::Night, Kind::Black}) {
        const Padded hdr = padded(kind, LightMapLayout::Hdr), ratio = padded(kind, LightMapLayout::Ratio);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                if (hdr.mean.coverage.at(x, y) != 0x1p-8f) continue;
                for (int c = 0; c < 3; ++c) {
                    const float dc = hdr.solved.values[0].at(x, y)[c];
                    EXPECT_GE(dc, 0);
                    for (std::size_t i = 1; i < lighting::kShCount; ++i) {
                        EXPECT_GE(hdr.solved.values[i].at(x, y)[c], hdr.plan.constants.at("bias")[i - 1] * dc - 1e-6f * dc);
                        EXPECT_LE(std::abs(ratio.solved.values[i].at(x, y)[c]), 2.8f * ratio.solved.values[0].at(x, y)[c]);
                    }
                }
            }
    }
}

}  // namespace
}  // namespace lightcook
