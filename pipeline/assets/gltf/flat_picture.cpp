// Two passes over the bake: a histogram of the brightest channels, by which the picture is exposed, then the picture.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/padding.h"
#include "lighting/radiometry.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

constexpr int kPadding = 2;
constexpr int kBinsPerOctave = 32, kLowestExponent = -40, kOctaves = 80;
constexpr double kShareWithin = 0.999;

using Histogram = std::array<std::int64_t, static_cast<std::size_t>(kBinsPerOctave* kOctaves)>;

/// Returns the irradiance of a texel: at its own normal, or without normals that of the mean light.
glm::vec3 irradianceAt(const formats::LightMapStrip& strip, bool hasNormals, int x, int y) {
    constexpr float kMeanOfFirst = 0.28209479f;  // 1 / sqrt(4 pi)
    const lighting::ShRgb& sh = strip.sh.at(x, y);
    const glm::vec3 exit = hasNormals ? lighting::lambertExitRadiance(sh, strip.normal.at(x, y), glm::vec3(1)).value : kMeanOfFirst * sh[0];
    return glm::max(std::numbers::pi_v<float> * exit, glm::vec3(0));
}

float largestOf(const glm::vec3& value) {
    return std::max({value.x, value.y, value.z});
}

/// Returns the upper edge of the bin that kShareWithin of the texels lie within; 1 for a black map.
double intensityOf(const Histogram& histogram) {
    std::int64_t total = 0, within = 0;
    for (const std::int64_t count : histogram) total += count;
    for (std::size_t bin = 0; bin < histogram.size() && total > 0; ++bin) {
        within += histogram[bin];
        if (static_cast<double>(within) >= kShareWithin * static_cast<double>(total))
            return std::exp2((static_cast<double>(bin) + 1) / kBinsPerOctave + kLowestExponent);
    }
    return 1;
}

/// Returns the irradiance of rows of a strip. Texels outside charts within kPadding of one take the mean of their nearest neighbours.
formats::Image<glm::vec3> paddedRows(const formats::LightMapStrip& strip, bool hasNormals, int firstRow, int rowCount) {
    formats::Image<glm::vec3> rows(strip.sh.width(), rowCount);
    for (int row = 0; row < rowCount; ++row) {
        const int y = firstRow + row - strip.firstRow;
        for (int x = 0; x < rows.width(); ++x) {
            glm::vec3& out = rows.at(x, row);
            if (strip.covered.at(x, y) != 0) {
                out = irradianceAt(strip, hasNormals, x, y);
                continue;
            }
            const int count = formats::visitNearestCovered(strip.covered.view(), x, y, kPadding,
                                                           [&](int nx, int ny) { out += irradianceAt(strip, hasNormals, nx, ny); });
            if (count > 0) out /= static_cast<float>(count);
        }
    }
    return rows;
}

}  // namespace

Result<FlatPicture> flatPictureOf(LightMapSource& source, const ActionContext& context) {
    const bool hasNormals = source.hasNormals();
    Histogram histogram{};
    const auto countStrip = [&](int index) -> Result<Histogram> {
        LC_TRY(strip, source.stripWithMargin(index, 0, 0));
        Histogram part{};
        for (int y = 0; y < strip->sh.height(); ++y)
            for (int x = 0; x < strip->sh.width(); ++x) {
                const float largest = strip->covered.at(x, y) != 0 ? largestOf(irradianceAt(*strip, hasNormals, x, y)) : 0.0f;
                if (!(largest > 0)) continue;
                const double bin = std::floor((std::log2(static_cast<double>(largest)) - kLowestExponent) * kBinsPerOctave);
                ++part[static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(part.size() - 1)))];
            }
        return part;
    };
    const auto counted =
        foldInOrder<Histogram>(source.stripCount(), context, "measure " + context.action.asset, countStrip, [&](const Histogram& part) {
            for (std::size_t bin = 0; bin < part.size(); ++bin) histogram[bin] += part[bin];
        });
    if (!counted) return tl::make_unexpected(counted.error());

    FlatPicture picture{formats::Image<glm::u8vec3>(source.width(), source.height()), intensityOf(histogram)};
    const float scale = static_cast<float>(255 / picture.intensity);
    const auto drawStrip = [&](int index) -> Result<int> {
        LC_TRY(strip, source.stripWithMargin(index, kPadding, kPadding));
        const int firstRow = source.stripFirstRow(index), rowCount = source.stripRows(index);
        const formats::Image<glm::vec3> rows = paddedRows(*strip, hasNormals, firstRow, rowCount);
        for (int row = 0; row < rowCount; ++row)
            for (int x = 0; x < rows.width(); ++x)
                picture.texels.at(x, firstRow + row) = glm::u8vec3(glm::clamp(scale * rows.at(x, row) + 0.5f, 0.0f, 255.0f));
        return 0;
    };
    LC_TRY(drawn, mapInOrder<int>(source.stripCount(), context, "draw " + context.action.asset, drawStrip));
    return picture;
}

}  // namespace lightcook::pipeline
