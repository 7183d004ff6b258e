#include "verify/cubemap.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "lighting/cube.h"
#include "lighting/sphere.h"

namespace lightcook::verify {
namespace {

constexpr double kDarkest = 0.02;       ///< smallest denominator of an error, relative to the mean radiance
constexpr double kLeastWeight = 1e-12;  ///< a place with a smaller sum of weights faces the centre of no texel [sr]

/// Sums over the centres of some texels of the source, each weighted by its solid angle. For a normal n, max(0, n.l + wrap) is linear in l
/// wherever it is positive: the sum over texels that all see the normal is a product of these sums with it, exactly.
struct Block {
    glm::dvec3 centre{0};  ///< near the directions l
    double reach = 0;      ///< largest distance of an l from it
    double weight = 0;
    glm::dvec3 turn{0};       ///< sum of l
    glm::dvec3 light{0};      ///< sum of the radiance L
    glm::dmat3 lightTurn{0};  ///< [channel] sum of L l

    void add(const glm::dvec3& direction, double solidAngle, const glm::dvec3& radiance) {
        weight += solidAngle;
        turn += solidAngle * direction;
        light += solidAngle * radiance;
        for (int channel = 0; channel < 3; ++channel) lightTurn[channel] += solidAngle * radiance[channel] * direction;
    }
    void add(const Block& part) {
        weight += part.weight;
        turn += part.turn;
        light += part.light;
        lightTurn += part.lightTurn;
    }
};

/// Sum of max(0, n.l + wrap) and of the same times L, over texels.
struct Reference {
    glm::dvec3 normal;
    double wrap;
    double weight = 0;
    glm::dvec3 light{0};

    void add(const glm::dvec3& direction, double solidAngle, const glm::dvec3& radiance) {
        const double product = std::max(0.0, glm::dot(normal, direction) + wrap) * solidAngle;
        weight += product;
        light += product * radiance;
    }
    void add(const Block& block) {
        weight += glm::dot(normal, block.turn) + wrap * block.weight;
        light += normal * block.lightTurn + wrap * block.light;
    }
};

/// The texels of an environment in a tree of blocks. Only blocks that a normal's horizon runs through are opened, and so the sum over all
/// texels takes time like the length of the horizon.
class SourceTree {
public:
    explicit SourceTree(const formats::Environment& environment)
        : texels_(environment.texels),
          isPanorama_(environment.projection == formats::Environment::Projection::Equirectangular),
          width_(texels_.width()),
          faceHeight_(isPanorama_ ? texels_.height() : width_) {
        if (isPanorama_)
            for (int x = 0; x < width_; ++x) columns_.push_back(lighting::directionFromEquirectangular({(x + 0.5) / width_, 0.5}));
        for (int y = 0; y < faceHeight_; ++y) {
            if (isPanorama_) {
                rows_.push_back(lighting::directionFromEquirectangular({0.5, (y + 0.5) / faceHeight_}));
                solidAngles_.push_back(lighting::equirectangularTexelSolidAngle(y, width_, faceHeight_));
            } else {
                for (int x = 0; x < width_; ++x) solidAngles_.push_back(lighting::cubeTexelSolidAngle(x, y, width_));
            }
        }
        addBlocksOfTexels();
        while (levels_.back().across * levels_.back().down > 1) addBlocksOfBlocks();
    }

    /// Adds all texels.
    void addTo(Reference& reference) const {
        for (int face = 0; face < texels_.height() / faceHeight_; ++face) add(static_cast<int>(levels_.size()) - 1, face, 0, 0, reference);
    }

    /// Returns the mean radiance over sphere and channels.
    double meanRadiance() const {
        double all = 0;
        for (const Block& face : levels_.back().blocks) all += face.light.x + face.light.y + face.light.z;
        return all / 3 / (4 * std::numbers::pi);
    }

private:
    static constexpr int kSide = 8;  ///< of the smallest blocks [texels]

    struct Level {
        int across, down;           ///< blocks of a face
        std::vector<Block> blocks;  ///< face after face, row after row

        const Block& at(int face, int x, int y) const { return blocks[static_cast<std::size_t>((face * down + y) * across + x)]; }
    };

    /// y  row of all faces
    glm::dvec3 direction(int x, int y) const {
        if (!isPanorama_) return lighting::cubeTexelDirection(y / width_, x, y % width_, width_);
        const glm::dvec3 &column = columns_[static_cast<std::size_t>(x)], &row = rows_[static_cast<std::size_t>(y)];
        return {-row.z * column.x, row.y, -row.z * column.z};
    }
    double solidAngle(int x, int y) const { return solidAngles_[static_cast<std::size_t>(isPanorama_ ? y : y % width_ * width_ + x)]; }
    /// Calls visit(x, y) for the texels of a smallest block.
    template <class Visit>
    void forTexels(int face, int blockX, int blockY, Visit visit) const {
        for (int y = blockY * kSide; y < std::min((blockY + 1) * kSide, faceHeight_); ++y)
            for (int x = blockX * kSide; x < std::min((blockX + 1) * kSide, width_); ++x) visit(x, face * faceHeight_ + y);
    }

    void addBlocksOfTexels() {
        Level level{(width_ + kSide - 1) / kSide, (faceHeight_ + kSide - 1) / kSide, {}};
        for (int face = 0; face < texels_.height() / faceHeight_; ++face)
            for (int blockY = 0; blockY < level.down; ++blockY)
                for (int blockX = 0; blockX < level.across; ++blockX) {
                    Block& block = level.blocks.emplace_back();
                    forTexels(face, blockX, blockY,
                              [&](int x, int y) { block.add(direction(x, y), solidAngle(x, y), glm::dvec3(texels_.at(x, y))); });
                    block.centre = block.turn / block.weight;
                    forTexels(face, blockX, blockY,
                              [&](int x, int y) { block.reach = std::max(block.reach, glm::distance(block.centre, direction(x, y))); });
                }
        levels_.push_back(std::move(level));
    }

    void addBlocksOfBlocks() {
        const Level& parts = levels_.back();
        Level level{(parts.across + 1) / 2, (parts.down + 1) / 2, {}};
        for (int face = 0; face < texels_.height() / faceHeight_; ++face)
            for (int y = 0; y < level.down; ++y)
                for (int x = 0; x < level.across; ++x) {
                    Block& block = level.blocks.emplace_back();
                    forParts(parts, x, y, [&](int partX, int partY) { block.add(parts.at(face, partX, partY)); });
                    block.centre = block.turn / block.weight;
                    forParts(parts, x, y, [&](int partX, int partY) {
                        const Block& part = parts.at(face, partX, partY);
                        block.reach = std::max(block.reach, glm::distance(block.centre, part.centre) + part.reach);
                    });
                }
        levels_.push_back(std::move(level));
    }

    /// Calls visit(x, y) for the blocks of a level that a block of the next one is made of.
    template <class Visit>
    static void forParts(const Level& parts, int x, int y, Visit visit) {
        for (int partY = 2 * y; partY < std::min(2 * y + 2, parts.down); ++partY)
            for (int partX = 2 * x; partX < std::min(2 * x + 2, parts.across); ++partX) visit(partX, partY);
    }

    void add(int level, int face, int x, int y, Reference& reference) const {
        const Block& block = levels_[static_cast<std::size_t>(level)].at(face, x, y);
        const double middle = glm::dot(reference.normal, block.centre) + reference.wrap;
        if (middle + block.reach <= 0) return;
        if (middle - block.reach >= 0) return reference.add(block);
        if (level > 0)
            return forParts(levels_[static_cast<std::size_t>(level - 1)], x, y,
                            [&](int partX, int partY) { add(level - 1, face, partX, partY, reference); });
        forTexels(face, x, y, [&](int texelX, int texelY) {
            reference.add(direction(texelX, texelY), solidAngle(texelX, texelY), glm::dvec3(texels_.at(texelX, texelY)));
        });
    }

    const formats::Image<glm::vec3>& texels_;
    bool isPanorama_;
    int width_, faceHeight_;
    std::vector<glm::dvec3> columns_, rows_;  ///< of a panorama: directions of the middle row and column
    std::vector<double> solidAngles_;         ///< of a panorama's rows, or of the texels of a face
    std::vector<Level> levels_;               ///< the smallest blocks first
};

}  // namespace

IrradianceFigures compareIrradiance(std::span<const formats::Image<glm::vec4>> faces, float range, double wrap,
                                    const formats::Environment& environment) {
    assert(faces.size() == 6);
    const int size = faces[0].width();
    const SourceTree source(environment);
    const double floor = kDarkest * source.meanRadiance();
    IrradianceFigures figures;
    figures.texelCount = 6 * size * size;
    double squares = 0, references = 0;
    for (int texel = 0; texel < figures.texelCount; ++texel) {
        const int face = texel / (size * size), y = texel / size % size, x = texel % size;
        Reference reference{lighting::cubeTexelDirection(face, x, y, size), wrap};
        source.addTo(reference);
        if (!(reference.weight > kLeastWeight)) continue;  // there is none
        const glm::dvec3 light = reference.light / reference.weight,
                         cooked = static_cast<double>(range) * glm::dvec3(faces[static_cast<std::size_t>(face)].at(x, y));
        for (int channel = 0; channel < 3; ++channel) {
            const double error = std::abs(cooked[channel] - light[channel]);
            if (!std::isfinite(error)) {
                figures.relRms = figures.worst = std::numeric_limits<double>::max();
                return figures;
            }
            squares += error * error;
            references += light[channel] * light[channel];
            if (error > 0) figures.worst = std::max(figures.worst, error / (light[channel] + floor));
        }
    }
    figures.relRms = squares > 0 ? std::sqrt(squares / references) : 0;
    return figures;
}

}  // namespace lightcook::verify
