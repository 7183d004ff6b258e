#include "verify/cubemap.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "lighting/cube.h"
#include "lighting/quadratic.h"
#include "lighting/sphere.h"
#include "shaders/lightcook_cpp.h"
#include "verify/random.h"
#include "verify/texture_unit.h"

namespace verify {
namespace {

using formats::Environment;

/// Beckmann's prefilter kernel before its division by its integral: D(NoH) c with n = v = r, so that NoH is the cosine of half the angle.
double kernelShape(double c, double m) {
    const double sinHalfSquared = 0.5 * (1 - c), NoHSquared = 1 - sinHalfSquared;
    return std::exp(-sinHalfSquared / (NoHSquared * m * m)) / (NoHSquared * NoHSquared) * c;
}

/// Angle [rad] beyond which the kernel is under 1e-7 of its peak, or zero.
double kernelSupport(double m) {
    return std::min(2 * std::atan(4 * m), 0.5 * std::numbers::pi);
}

lighting::ShDouble channelOf(const lighting::ShRgb& sh, int channel) {
    lighting::ShDouble coefficients{};
    for (std::size_t i = 0; i < sh.size(); ++i) coefficients[i] = sh[i][channel];
    return coefficients;
}

bool isFinite(const lighting::ShDouble& coefficients, const lighting::ShBands& bands) {
    const auto finite = [](double value) { return std::isfinite(value); };
    return std::all_of(coefficients.begin(), coefficients.end(), finite) && std::all_of(bands.begin(), bands.end(), finite);
}

struct Range {
    double low, high;
};

/// The largest local relative error of any result against any reference of two ranges. The error falls with the reference below the
/// result and grows above it, so that it peaks at an end.
double largestLocalError(Range reference, Range result, double key) {
    const double floor = 0.02 * key;
    const double above = result.high > reference.low ? (result.high - reference.low) / (reference.low + floor) : 0;
    const double below = reference.high > result.low ? (reference.high - result.low) / (reference.high + floor) : 0;
    return std::max(above, below);
}

Range storedRange(const CookedCubemap::Mip& mip, int channel) {
    Range range{std::numeric_limits<double>::max(), -std::numeric_limits<double>::max()};
    for (const auto& face : mip.faces)
        for (const glm::vec4& texel : face.texels()) {
            range.low = std::min(range.low, static_cast<double>(texel[channel]));
            range.high = std::max(range.high, static_cast<double>(texel[channel]));
        }
    return range;
}

/// Sound for every direction, but loose: all that is known of the reference is that it lies between the ends of its source, and of the
/// result that a filter gives no more than the largest stored value, times the exact maximum of S. Infinite where S is not positive.
double boundOf(const CookedCubemap& map, const CubemapReference& reference, double key) {
    double bound = 0;
    for (const CookedCubemap::Mip& mip : map.mips)
        for (int channel = 0; channel < 3; ++channel) {
            const lighting::ShDouble coefficients = channelOf(map.windowedSh, channel);
            if (!isFinite(coefficients, mip.bands)) return std::numeric_limits<double>::infinity();
            const lighting::Extrema s = lighting::extremaOnSphere(lighting::sphereQuadratic(coefficients, mip.bands));
            if (!(s.minimum > 0)) return std::numeric_limits<double>::infinity();
            const Range stored = storedRange(mip, channel);
            // 1e-5: the shader evaluates S in floats.
            const Range result{map.range * stored.low * s.minimum * (1 - 1e-5), map.range * stored.high * s.maximum * (1 + 1e-5)};
            bound = std::max(bound, largestLocalError({reference.smallest()[channel], reference.largest()[channel]}, result, key));
        }
    return bound;
}

}  // namespace

CubemapReference::CubemapReference(const Environment& environment) : environment_(environment) {
    const auto texels = environment.texels.view();
    const bool isPanorama = environment.projection == Environment::Projection::Equirectangular;
    assert(texels.width > 0 && texels.height == (isPanorama ? texels.width / 2 : 6 * texels.width));
    texelWidth_ = isPanorama ? 2 * std::numbers::pi / texels.width : 2.0 / texels.width;
    texels_.resize(static_cast<std::size_t>(texels.width) * static_cast<std::size_t>(texels.height));
    smallest_ = largest_ = glm::dvec3(texels.at(0, 0));
    double total = 0;
    for (std::size_t i = 0; i < texels_.size(); ++i) {
        const glm::dvec3 radiance(environment.texels.texels()[i]);
        visitPieces(i, 1, [&](const glm::dvec3& direction, double solidAngle) {
            texels_[i] = {glm::vec3(direction), static_cast<float>(solidAngle)};
            mean_ += solidAngle * radiance;
            total += solidAngle;
        });
        smallest_ = glm::min(smallest_, radiance);
        largest_ = glm::max(largest_, radiance);
    }
    mean_ /= total;
    makeTiles();
}

template <class Visit>
void CubemapReference::visitPieces(std::size_t texel, int pieces, const Visit& visit) const {
    const int width = environment_.texels.width(), height = environment_.texels.height();
    const int x = static_cast<int>(texel % static_cast<std::size_t>(width)), y = static_cast<int>(texel / static_cast<std::size_t>(width));
    const bool isPanorama = environment_.projection == Environment::Projection::Equirectangular;
    for (int row = 0; row < pieces; ++row) {
        const int pieceY = y * pieces + row;
        const double rowAngle = isPanorama ? lighting::equirectangularTexelSolidAngle(pieceY, width * pieces, height * pieces) : 0;
        for (int column = 0; column < pieces; ++column) {
            const int pieceX = x * pieces + column;
            if (isPanorama) {
                const glm::dvec2 uv((pieceX + 0.5) / (width * pieces), (pieceY + 0.5) / (height * pieces));
                visit(lighting::directionFromEquirectangular(uv), rowAngle);
            } else {
                const int size = width * pieces;
                const glm::dvec2 uv((2.0 * pieceX + 1) / size - 1, (2.0 * (pieceY % size) + 1) / size - 1);
                // Of pieces the density at their middle will do: 4 / size^2 (1 + u^2 + v^2)^(-3/2).
                const double squared = 1 + glm::dot(uv, uv), middle = 4 / (static_cast<double>(size) * size * squared * std::sqrt(squared));
                visit(lighting::directionFromCube({pieceY / size, uv}),
                      pieces == 1 ? lighting::cubeTexelSolidAngle(pieceX, pieceY % size, size) : middle);
            }
        }
    }
}

void CubemapReference::makeTiles() {
    constexpr int kTileSize = 16;
    const int width = environment_.texels.width(), height = environment_.texels.height();
    const bool isStrip = environment_.projection == Environment::Projection::CubeStrip;
    const int faceHeight = isStrip ? width : height;  // a tile stays on its face
    for (int face = 0; face < height; face += faceHeight)
        for (int top = face; top < face + faceHeight; top += kTileSize)
            for (int left = 0; left < width; left += kTileSize) {
                Tile tile;
                for (int y = top; y < std::min(top + kTileSize, face + faceHeight); ++y)
                    for (int x = left; x < std::min(left + kTileSize, width); ++x) {
                        tile.texels.push_back(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
                        tile.centre += glm::dvec3(texels_[tile.texels.back()].direction);
                    }
                const double length = glm::length(tile.centre);
                tile.centre = length > 1e-6 ? tile.centre / length : glm::dvec3(0, 1, 0);
                for (const std::size_t texel : tile.texels) {
                    const double c = glm::dot(tile.centre, glm::dvec3(texels_[texel].direction));
                    tile.radius = std::max(tile.radius, std::acos(std::clamp(c, -1.0, 1.0)));
                }
                tiles_.push_back(std::move(tile));
            }
}

glm::dvec3 CubemapReference::prefiltered(const glm::dvec3& direction, double m, double piecesPerWidth) const {
    assert(0 < m && m <= 1);
    // One standard deviation of the lobe is sqrt(2) m: pieces an eighth of it widen it by a thousandth.
    const double width = std::numbers::sqrt2 * m;
    const int pieces = std::clamp(static_cast<int>(std::ceil(piecesPerWidth * texelWidth_ / width)), 1, 256);
    const double reach = kernelSupport(m) + texelWidth_, farthest = std::cos(std::min(reach, std::numbers::pi));
    glm::dvec3 sum(0);
    double weightSum = 0;
    for (const Tile& tile : tiles_) {
        if (glm::dot(tile.centre, direction) < std::cos(std::min(reach + tile.radius + 1e-6, std::numbers::pi))) continue;
        for (const std::size_t i : tile.texels) {
            const double centreCosine = glm::dot(glm::dvec3(texels_[i].direction), direction);
            if (centreCosine < farthest) continue;
            const auto add = [&](double c, double solidAngle) {
                if (c <= 0) return;
                const double weight = solidAngle * kernelShape(c, m);
                sum += weight * glm::dvec3(environment_.texels.texels()[i]);
                weightSum += weight;
            };
            if (pieces == 1)
                add(centreCosine, static_cast<double>(texels_[i].solidAngle));
            else
                visitPieces(i, pieces,
                            [&](const glm::dvec3& towards, double solidAngle) { add(glm::dot(towards, direction), solidAngle); });
        }
    }
    return weightSum > 0 ? sum / weightSum : glm::dvec3(0);
}

glm::dvec3 CubemapReference::radianceAt(const glm::dvec3& direction) const {
    const auto texels = environment_.texels.view();
    const auto index = [](double coordinate, int size) { return std::clamp(static_cast<int>(coordinate * size), 0, size - 1); };
    if (environment_.projection == Environment::Projection::Equirectangular) {
        const glm::dvec2 uv = lighting::equirectangularFromDirection(direction);
        return glm::dvec3(texels.at(index(uv.x, texels.width), index(uv.y, texels.height)));
    }
    const lighting::CubeCoordinate place = lighting::cubeFromDirection(direction);
    return glm::dvec3(
        texels.at(index(0.5 * (place.uv.x + 1), texels.width), place.face * texels.width + index(0.5 * (place.uv.y + 1), texels.width)));
}

glm::dvec3 CubemapReference::footprintMean(const glm::dvec3& direction, int size, int places) const {
    const lighting::CubeCoordinate centre = lighting::cubeFromDirection(direction);
    const double step = 2.0 / (static_cast<double>(size) * places);
    glm::dvec3 sum(0);
    double weightSum = 0;
    for (int j = 0; j < places; ++j)
        for (int i = 0; i < places; ++i) {
            const glm::dvec2 uv = centre.uv + step * (glm::dvec2(i, j) + 0.5 - 0.5 * places);
            const double squared = 1 + glm::dot(uv, uv), weight = 1 / (squared * std::sqrt(squared));
            sum += weight * radianceAt(lighting::directionFromCube({centre.face, uv}));
            weightSum += weight;
        }
    return sum / weightSum;
}

std::vector<CubemapSample> cubemapSamples(const CookedCubemap& map, const CubemapSampling& sampling) {
    std::vector<CubemapSample> samples;
    Random random(sampling.seed);
    for (int mip = 0; mip < static_cast<int>(map.mips.size()); ++mip) {
        const int size = map.mips[static_cast<std::size_t>(mip)].faces[0].width(), count = 6 * size * size;
        const auto addTexel = [&](int index) {
            const int face = index / (size * size), y = index / size % size, x = index % size;
            samples.push_back({mip, true, face, x, y, lighting::cubeTexelDirection(face, x, y, size)});
        };
        if (count <= sampling.texelsPerMip)
            for (int index = 0; index < count; ++index) addTexel(index);
        else
            for (int i = 0; i < sampling.texelsPerMip; ++i) addTexel(random.below(count));
        for (int i = 0; i < sampling.directionsPerMip; ++i) samples.push_back({mip, false, 0, 0, 0, random.direction()});
    }
    return samples;
}

glm::dvec3 shadeCubemap(const CookedCubemap& map, int mip, const glm::vec3& stored, const glm::dvec3& direction) {
    shaders::LcSh sh;
    for (std::size_t i = 0; i < map.windowedSh.size(); ++i) sh.c[i] = map.windowedSh[i];
    const lighting::ShBands& bands = map.mips[static_cast<std::size_t>(mip)].bands;
    const glm::vec3 s = shaders::lcZonalSpecular(sh, glm::vec3(direction), glm::vec3(glm::dvec3(bands[0], bands[1], bands[2])));
    return glm::dvec3(shaders::lcEnvironment(map.range * stored, s));
}

CubemapResult compareCubemap(const CookedCubemap& map, const CubemapReference& reference, const CubemapSample& sample) {
    const CookedCubemap::Mip& mip = map.mips[static_cast<std::size_t>(sample.mip)];
    const glm::vec4 stored =
        sample.isTexel ? mip.faces[static_cast<std::size_t>(sample.face)].at(sample.x, sample.y) : sampleCube(mip.faces, sample.direction);
    CubemapResult result;
    result.cooked = shadeCubemap(map, sample.mip, glm::vec3(stored), sample.direction);
    // 128 places a side meet an edge between two source texels within half a step: 0.4 % of their difference at worst.
    result.reference =
        mip.m > 0 ? reference.prefiltered(sample.direction, mip.m) : reference.footprintMean(sample.direction, mip.faces[0].width(), 128);
    return result;
}

std::vector<StageError> cubemapStages(const CookedCubemap& map, const CubemapReference& reference, std::span<const CubemapSample> samples,
                                      std::span<const CubemapResult> results, const glm::vec3& luminanceWeights) {
    assert(samples.size() == results.size());
    const double key = glm::dot(reference.mean(), glm::dvec3(luminanceWeights));
    ErrorAccumulator divide(key), filter(key);
    for (std::size_t i = 0; i < samples.size(); ++i)
        for (int channel = 0; channel < 3; ++channel)
            (samples[i].isTexel ? divide : filter).add(results[i].reference[channel], results[i].cooked[channel]);
    const double bound = boundOf(map, reference, key);
    divide.addBound(bound);
    filter.addBound(bound);
    if (!std::isfinite(bound)) divide.add(0, bound);  // no sample may have met the direction in which S is not positive
    std::vector<StageError> stages = {
        {"divide", {}, divide.figures(), 0}, {"filter", {}, filter.figures(), 0}, {"total", {}, divide.figures(), 0}};
    stages[2].specular.maxSampled = std::max(stages[0].specular.maxSampled, stages[1].specular.maxSampled);
    return stages;
}

}  // namespace verify
