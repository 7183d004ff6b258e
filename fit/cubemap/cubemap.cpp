#include "fit/cubemap.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>

#include "fit/cubemap/area_resample.h"
#include "fit/cubemap/kernel.h"
#include "fit/cubemap/tree.h"
#include "lighting/cube.h"

namespace lightcook::fit {
namespace {

/// Side of the blocks of texels that share one list of cells [texels].
constexpr int kBlock = 4;
/// Narrowest filtered kernel, relative to the width of a texel: below it the texel's own footprint is the wider filter.
constexpr double kNarrowestKernel = 0.25;
/// Widest piece of a source texel, relative to the width of the narrowest kernel. Cells widen the kernel by the spread of their pieces,
/// except for GGX: there a piece adds an error of 1/12 of its square.
constexpr double kPiecePerKernelWidth = 0.25, kPiecePerGgxWidth = 0.2;
/// A cell has separate entries for area and flux if their centroids are farther apart than this part of its size. Near a sun all centroids
/// of flux lean towards it: with 0.1 of the size, areas weighed 0.4 % too much.
constexpr double kSplitDistance = 0.02;
/// [chord^2 over the kernel's width^2] Reach of kSplitDistance: cells beyond weigh less than a hundredth.
constexpr double kSplitReach = 9, kSplitDistanceInTail = 0.1;
/// Largest errors, relative to the environment's mean, that a bright cell may cause without being opened.
constexpr double kSpreadError = 1e-4, kHorizonError = 2e-5;
/// The same for a common centroid of the three channels; beyond it each channel has an entry.
constexpr double kColourError = 1e-4;
/// [rad] Cells wider than this are always subdivided, for light sources 10,000 times as bright as their surroundings: their position in a
/// coarse cell would matter. Finer cells for all (four times as many as narrow lobes need) would take half of the whole time.
constexpr double kWidestFineCell = 0.012;

/// Entries as columns for the inner loop, which processes one entry for eight texels at a time.
struct CellList {
    std::vector<float> x, y, z, sharpness, solidAngle, red, green, blue;
    void clear() {
        for (std::vector<float>* column : {&x, &y, &z, &sharpness, &solidAngle, &red, &green, &blue}) column->clear();
    }
    void add(const glm::vec3& direction, KernelScale::Softened kernel, float entrySolidAngle, const glm::vec3& flux) {
        x.push_back(direction.x);
        y.push_back(direction.y);
        z.push_back(direction.z);
        sharpness.push_back(kernel.sharpness);
        solidAngle.push_back(kernel.amplitude * entrySolidAngle);
        red.push_back(kernel.amplitude * flux.x);
        green.push_back(kernel.amplitude * flux.y);
        blue.push_back(kernel.amplitude * flux.z);
    }
};

struct Eight {
    Double8 weight{}, red{}, green{}, blue{};
};
/// Entries summed in float before the sum is added to a double: 64 roundings stay below 1e-6, thousands do not.
constexpr std::size_t kEntriesPerPartialSum = 64;

template <PrefilterKernel kKernel, bool kNarrow>
Eight sumCells(const CellList& list, const KernelScale& scale, Float8 x, Float8 y, Float8 z) {
    Eight sum;
    for (std::size_t first = 0; first < list.x.size(); first += kEntriesPerPartialSum) {
        const std::size_t end = std::min(list.x.size(), first + kEntriesPerPartialSum);
        Float8 weight{}, red{}, green{}, blue{};
        for (std::size_t i = first; i < end; ++i) {
            const Float8 dx = x - list.x[i], dy = y - list.y[i], dz = z - list.z[i];
            const Float8 shape = kernelShape<kKernel, kNarrow>(dx * dx + dy * dy + dz * dz, list.sharpness[i], scale);
            weight += shape * list.solidAngle[i];
            red += shape * list.red[i];
            green += shape * list.green[i];
            blue += shape * list.blue[i];
        }
        sum.weight += __builtin_convertvector(weight, Double8);
        sum.red += __builtin_convertvector(red, Double8);
        sum.green += __builtin_convertvector(green, Double8);
        sum.blue += __builtin_convertvector(blue, Double8);
    }
    return sum;
}

template <PrefilterKernel kKernel>
Eight sumCells(const CellList& list, const KernelScale& scale, Float8 x, Float8 y, Float8 z) {
    return scale.isNarrow ? sumCells<kKernel, true>(list, scale, x, y, z) : sumCells<kKernel, false>(list, scale, x, y, z);
}

Eight sumCells(const CellList& list, const KernelScale& scale, Float8 x, Float8 y, Float8 z) {
    switch (scale.kernel) {
        case PrefilterKernel::Beckmann:
            return sumCells<PrefilterKernel::Beckmann>(list, scale, x, y, z);
        case PrefilterKernel::Ggx:
            return sumCells<PrefilterKernel::Ggx>(list, scale, x, y, z);
        case PrefilterKernel::Phong:
            break;
    }
    return sumCells<PrefilterKernel::Phong>(list, scale, x, y, z);
}

/// Directions around a centre.
struct Cap {
    glm::vec3 centre;   ///< unit
    double radius = 0;  ///< [chord]
};

/// Collects the entries of the tree that stand for the source in all directions of a cap.
class Gatherer {
public:
    Gatherer(const CellTree& tree, const KernelScale& scale, double cellsPerKernelWidth)
        : tree_(tree), scale_(scale), widthToSize_(1 / cellsPerKernelWidth) {
        double brightness = 0;
        for (int face = 0; face < 6; ++face) brightness += brightnessOf(tree.levels.front().at(face, 0, 0));
        const double ofMean = brightness * scale.integral / (4 * std::numbers::pi);
        brightSpreadLimit_ = kSpreadError * ofMean;
        brightHorizonLimit_ = kHorizonError * ofMean;
        colourLimit_ = static_cast<float>(kColourError * ofMean * std::sqrt(scale.widthSquared));
    }

    void gather(const Cap& cap, CellList& out) const {
        out.clear();
        for (int face = 0; face < 6; ++face) visit({0, face, 0, 0}, cap, out);
    }

private:
    struct CellIndex {
        std::size_t level;
        int face, x, y;
    };

    void visit(const CellIndex& at, const Cap& cap, CellList& out) const {
        const CellLevel& level = tree_.levels[at.level];
        const Cell& cell = level.at(at.face, at.x, at.y);
        if (cell.solidAngle == 0) return;
        const double distance =
            std::max(0.0, static_cast<double>(glm::distance(cap.centre, cell.areaCentroid)) - cap.radius - level.radius);
        if (distance > scale_.supportChord) return;
        const double allowed = widthToSize_ * widthToSize_ * scale_.widthSquaredAt(distance);
        const bool isFinest = at.level + 1 == tree_.levels.size();
        if (isFinest || (level.size * level.size <= allowed && !isTooBright(cell, cap.centre, distance, cap.radius + level.radius))) {
            emit(cell, level.size, distance * distance < kSplitReach * scale_.widthSquared ? kSplitDistance : kSplitDistanceInTail, out);
            return;
        }
        for (int child = 0; child < 4; ++child) visit({at.level + 1, at.face, 2 * at.x + child % 2, 2 * at.y + child / 2}, cap, out);
    }
    static double brightnessOf(const Cell& cell) { return static_cast<double>(cell.flux.x) + cell.flux.y + cell.flux.z; }
    /// Returns true if the flux of a cell is so large that its extent would be visible: by the kernel's curvature, or by its kink at the
    /// horizon r.l = 0 if the horizon of some direction crosses the cell.
    bool isTooBright(const Cell& cell, const glm::vec3& centre, double distance, double reach) const {
        const double brightness = brightnessOf(cell), spread = cell.fluxSpread;
        const double widthSquared = scale_.widthSquaredAt(distance);
        const double steepness = std::min(4.0, 1 + distance * distance / widthSquared);  // a tail is more curved than its height suggests
        if (brightness * spread * steepness > brightSpreadLimit_ * widthSquared) {
            const double shape = prefilterKernelShapeAt(scale_.kernel, scale_.m, 0.5 * distance * distance);
            if (brightness * spread * steepness * shape > brightSpreadLimit_ * widthSquared) return true;
        }
        const bool acrossHorizon = std::abs(glm::dot(centre, cell.fluxCentroid)) < reach;
        return acrossHorizon && brightness * std::sqrt(spread) * scale_.horizonSlope > brightHorizonLimit_;
    }
    void emit(const Cell& cell, double size, double splitDistance, CellList& out) const {
        const bool isSplit = glm::distance(cell.areaCentroid, cell.fluxCentroid) > splitDistance * size;
        enterCell(cell, cell.colourShift > colourLimit_, isSplit,
                  [&](const glm::vec3& centroid, float spread, float solidAngle, const glm::vec3& flux) {
                      out.add(centroid, scale_.softened(spread), solidAngle, flux);
                  });
    }

    const CellTree& tree_;
    const KernelScale& scale_;
    double widthToSize_;
    double brightSpreadLimit_ = 0, brightHorizonLimit_ = 0;
    float colourLimit_ = 0;
};

tl::unexpected<formats::Error> refuseCubemap(const std::string& what, const std::string& found, const std::string& expected) {
    return formats::failure(formats::ErrorCode::InvalidRequest, "cubemap, " + what, "found " + found + ", expected " + expected);
}

/// Returns the number of levels down to one texel a face: log2(size) + 1.
int levelCountOf(int size) {
    return static_cast<int>(std::bit_width(static_cast<unsigned>(size)));
}

formats::Result<void> check(const formats::Environment& environment, const CubemapOptions& options) {
    LC_CHECK(checkShape(environment, "cubemap"));
    if (options.size < 1 || options.size > 4096 || !std::has_single_bit(static_cast<unsigned>(options.size)))
        return refuseCubemap("size", std::to_string(options.size), "a power of two, 1 to 4096");
    const int longestChain = levelCountOf(options.size);
    if (options.mipCount < 0 || options.mipCount > longestChain)
        return refuseCubemap("mip count", std::to_string(options.mipCount), "0 to " + std::to_string(longestChain));
    const int mipCount = options.mipCount == 0 ? longestChain : options.mipCount;
    if (!options.roughness.empty() && static_cast<int>(options.roughness.size()) != mipCount)
        return refuseCubemap("roughness", std::to_string(options.roughness.size()) + " values", "one a mip, " + std::to_string(mipCount));
    for (const double m : options.roughness)
        if (!(m >= 0 && m <= 1)) return refuseCubemap("roughness", std::to_string(m), "0 to 1");
    if (!(options.cellsPerKernelWidth >= 1 && options.cellsPerKernelWidth <= 64))
        return refuseCubemap("cells per kernel width", std::to_string(options.cellsPerKernelWidth), "1 to 64");
    return {};
}

/// Returns the kernel of each level, without its band factors.
std::vector<MipKernel> kernelsOf(const CubemapOptions& options) {
    std::vector<MipKernel> mips;
    const int mipCount = options.mipCount == 0 ? levelCountOf(options.size) : options.mipCount;
    for (int mip = 0; mip < mipCount; ++mip) {
        MipKernel kernel;
        kernel.size = options.size >> mip;
        const double perceptual = mipCount > 1 ? static_cast<double>(mip) / (mipCount - 1) : 0;
        kernel.m = options.roughness.empty() ? perceptual * perceptual : options.roughness[static_cast<std::size_t>(mip)];
        kernel.perceptualRoughness = options.roughness.empty() ? perceptual : std::sqrt(kernel.m);
        mips.push_back(kernel);
    }
    return mips;
}

/// Texels brighter than this times the mean take a full share of the correction.
constexpr double kBrightOverMean = 1.5;

/// Corrects the mean of a channel as CubemapPrefilter::keepMean describes. If the excess is so large that values could become negative (a
/// narrow lobe on very few texels), all are scaled instead. Returns false if a texel was clamped to the brightest value.
bool keepChannelMean(int channel, double mean, double brightest, const std::vector<double>& solidAngles,
                     formats::ImageView<glm::vec3> strip) {
    const auto sumOf = [&](auto&& share) {
        double sum = 0;
        for (int y = 0; y < strip.height; ++y)
            for (int x = 0; x < strip.width; ++x)
                sum += solidAngles[static_cast<std::size_t>(y % strip.width * strip.width + x)] * share(strip.at(x, y)[channel]);
        return sum / (4 * std::numbers::pi);
    };
    const double found = sumOf([](double value) { return value; });
    if (!(found > 0)) return true;
    const auto share = [&](double value) {
        const double bright = std::min(value / (kBrightOverMean * found), 1.0);
        return value * bright * bright;
    };
    const double lack = mean - found, gain = lack / sumOf(share);
    bool isWhole = true;
    for (int y = 0; y < strip.height; ++y)
        for (int x = 0; x < strip.width; ++x) {
            const double value = strip.at(x, y)[channel], kept = gain > -0.5 ? value + gain * share(value) : value * mean / found;
            isWhole = isWhole && kept <= brightest;
            strip.at(x, y)[channel] = static_cast<float>(std::min(kept, brightest));
        }
    return isWhole;
}

}  // namespace

struct CubemapPrefilter::State {
    State(const formats::Environment& environment, const CubemapOptions& options) : mips(kernelsOf(options)), resampler(environment) {
        double narrowest = 1;
        int finestSize = 0;
        for (MipKernel& mip : mips) {
            scales.push_back(mip.m > 0 ? makeKernelScale(options.kernel, mip.m) : KernelScale{});
            const double width = std::sqrt(scales.back().widthSquared);
            if (width < kNarrowestKernel * 2 / mip.size) {
                mip.m = mip.perceptualRoughness = 0;
                cellsPerWidth.push_back(0);
                continue;
            }
            finestSize = std::max(finestSize, mip.size);
            cellsPerWidth.push_back(options.cellsPerKernelWidth * std::min(3.0, std::sqrt(static_cast<double>(finestSize) / mip.size)));
            mip.bands = prefilterKernelBands(options.kernel, mip.m);
            narrowest = std::min(narrowest, width);
        }
        buildTree(environment, options, narrowest);
    }

    void buildTree(const formats::Environment& environment, const CubemapOptions& options, double narrowest) {
        const double cellWidth = narrowest / options.cellsPerKernelWidth;
        tree = buildCellTree(environment, (cellWidth < kWidestFineCell ? 1 : 0.5) * cellWidth,
                             narrowest * (options.kernel == PrefilterKernel::Ggx ? kPiecePerGgxWidth : kPiecePerKernelWidth));
        double solidAngle = 0;
        for (const Cell& cell : tree.levels.front().cells) {
            mean += glm::dvec3(cell.flux);
            solidAngle += cell.solidAngle;
        }
        mean *= tree.brightest / solidAngle;
    }

    /// A block of a face of a level.
    struct Block {
        int mip, face, x, y;  ///< x, y: its first texel
    };
    /// Filters the texels of a block that lie in the rows [firstRow, firstRow + out.height) of the face. The cells depend on the block
    /// alone, so texels do not depend on how the rows are divided.
    /// list  memory for the cells
    void filterBlock(const Block& block, int firstRow, formats::ImageView<glm::vec3> out, CellList& list) const;

    std::vector<MipKernel> mips;
    std::vector<KernelScale> scales;
    AreaResampler resampler;
    CellTree tree;
    glm::dvec3 mean{0};                 ///< of the source, over the sphere
    std::vector<double> cellsPerWidth;  ///< of each mip
};

void CubemapPrefilter::State::filterBlock(const Block& block, int firstRow, formats::ImageView<glm::vec3> out, CellList& list) const {
    const auto mip = static_cast<std::size_t>(block.mip);
    const int size = mips[mip].size, edge = std::min(kBlock, size);
    const KernelScale& scale = scales[mip];
    const lighting::CubeCoordinate middle{block.face, {(2.0 * block.x + edge) / size - 1, (2.0 * block.y + edge) / size - 1}};
    const glm::dvec3 centre = lighting::directionFromCube(middle);
    std::array<glm::vec3, kBlock * kBlock> directions{};
    double radius = 0;
    for (int i = 0; i < edge * edge; ++i) {
        const glm::dvec3 direction = lighting::cubeTexelDirection(block.face, block.x + i % edge, block.y + i / edge, size);
        directions[static_cast<std::size_t>(i)] = glm::vec3(direction);
        radius = std::max(radius, glm::distance(direction, centre));
    }
    Gatherer(tree, scale, cellsPerWidth[mip]).gather({glm::vec3(centre), radius}, list);
    for (int first = 0; first < edge * edge; first += 8) {
        Float8 x{}, y{}, z{};
        for (int lane = 0; lane < 8; ++lane) {
            const glm::vec3& direction = directions[static_cast<std::size_t>(std::min(first + lane, edge * edge - 1))];
            x[lane] = direction.x;
            y[lane] = direction.y;
            z[lane] = direction.z;
        }
        const Eight sum = sumCells(list, scale, x, y, z);
        for (int lane = 0; lane < std::min(8, edge * edge - first); ++lane) {
            const int row = block.y + (first + lane) / edge - firstRow;
            if (row < 0 || row >= out.height) continue;
            const glm::dvec3 value = glm::dvec3(sum.red[lane], sum.green[lane], sum.blue[lane]) / sum.weight[lane];
            glm::vec3& texel = out.at(block.x + (first + lane) % edge, row);
            for (int channel = 0; channel < 3; ++channel)
                texel[channel] = static_cast<float>(std::clamp(value[channel], 0.0, 1.0) * tree.brightest);
        }
    }
}

formats::Result<CubemapPrefilter> CubemapPrefilter::create(const formats::Environment& environment, const CubemapOptions& options) {
    if (const formats::Result<void> checked = check(environment, options); !checked) return tl::make_unexpected(checked.error());
    return CubemapPrefilter(std::make_unique<State>(environment, options));
}

CubemapPrefilter::CubemapPrefilter(std::unique_ptr<State> state) : state_(std::move(state)) {}
CubemapPrefilter::CubemapPrefilter(CubemapPrefilter&&) noexcept = default;
CubemapPrefilter& CubemapPrefilter::operator=(CubemapPrefilter&&) noexcept = default;
CubemapPrefilter::~CubemapPrefilter() = default;

int CubemapPrefilter::mipCount() const {
    return static_cast<int>(state_->mips.size());
}
const std::vector<MipKernel>& CubemapPrefilter::mips() const {
    return state_->mips;
}

void CubemapPrefilter::filterRows(int mip, int face, int firstRow, formats::ImageView<glm::vec3> out) const {
    const MipKernel& level = state_->mips[static_cast<std::size_t>(mip)];
    assert(0 <= face && face < 6 && 0 <= firstRow && firstRow + out.height <= level.size && out.width == level.size);
    if (level.m == 0) {
        for (int y = 0; y < out.height; ++y)
            for (int x = 0; x < level.size; ++x) out.at(x, y) = glm::vec3(state_->resampler.mean(face, x, firstRow + y, level.size));
        return;
    }
    CellList list;
    const int edge = std::min(kBlock, level.size);
    for (int y = firstRow / edge * edge; y < firstRow + out.height; y += edge)
        for (int x = 0; x < level.size; x += edge) state_->filterBlock({mip, face, x, y}, firstRow, out, list);
}

void CubemapPrefilter::keepMean(int mip, formats::ImageView<glm::vec3> strip) const {
    const MipKernel& level = state_->mips[static_cast<std::size_t>(mip)];
    assert(strip.width == level.size && strip.height == 6 * level.size);
    if (level.m == 0) return;
    std::vector<double> solidAngles;
    for (int i = 0; i < level.size * level.size; ++i)
        solidAngles.push_back(lighting::cubeTexelSolidAngle(i % level.size, i / level.size, level.size));
    // Texels are clamped to the source's brightest value; the next round distributes the rest among the others.
    constexpr int kRounds = 4;
    for (int channel = 0; channel < 3; ++channel)
        for (int round = 0; round < kRounds; ++round)
            if (keepChannelMean(channel, state_->mean[channel], state_->tree.brightest, solidAngles, strip)) break;
}

formats::Image<glm::vec3> CubemapPrefilter::filterMip(int mip) const {
    const int size = state_->mips[static_cast<std::size_t>(mip)].size;
    formats::Image<glm::vec3> strip(size, 6 * size);
    for (int face = 0; face < 6; ++face) filterRows(mip, face, 0, strip.view().rows(face * size, size));
    keepMean(mip, strip.view());
    return strip;
}

}  // namespace lightcook::fit
