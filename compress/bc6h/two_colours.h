// BC6H blocks of two colours, encoded with the least possible error.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "compress/bc6h/search.h"
#include "compress/block/two_colours.h"

namespace lightcook::compress {

/// Branch and bound over every mode, every partition, every pair of indices for the colours of each region, and every pair of ends. A
/// branch is pruned where the lower bound of its error is not below the best error so far. Order: modes with one region first, then
/// partitions, those that separate the colours best first, because a small error found early prunes more.
///
/// Two things couple decisions that would otherwise be independent:
/// - Deltas. In transformed modes all ends of a channel lie within the reach of the first end, on the circle of codes (Window).
/// - Anchors. The index of an anchor texel has one bit less. If its colour wants an index in the upper half, either the ends are swapped,
///   or the anchor takes another index than the other texels of its colour ("parts" from it).
class Bc6hTwoColours {
public:
    Bc6hTwoColours(bool isSigned, const EncodeOptions& options);
    /// Returns the encoded block with the least error.
    Bc6hResult fit(const Block& block, const TwoColours& two);

private:
    /// The significant texels of a region.
    struct Region {
        std::array<double, 2> weight{};  ///< total significance of each colour
        int anchorColour = -1;           ///< -1: the anchor is not significant
        double anchorWeight = 0;
    };
    /// The indices of a region's colours, and the best ends for them if there were no other region.
    struct Placement {
        std::array<int, 2> index{};  ///< for each colour
        int anchorIndex = -1;        ///< index of an anchor that parts from its colour; -1: it does not
        const RegionSearch* search = nullptr;
        std::array<int, 3> shares{};  ///< interpolation weights of the search's loads
        std::array<Ends, 3> ends{};
        double error = 0;
    };
    /// A mode and its constraints on the ends.
    struct Mode {
        int number = 0, regionCount = 1, indexBits = 0;
        bool transformed = false;
        const EndValues* values = nullptr;
        std::array<int, 3> reach{};                         ///< for each channel: ends are in first - reach .. first + reach - 1
        std::array<Window, 3> firstWindows, secondWindows;  ///< for the ends of region 0; of region 1 when region 0 is not known yet
    };
    /// The searches of a region.
    struct Searches {
        explicit Searches(std::span<const ChannelError> channels, const Region& region);
        Region region;
        RegionSearch merged;  ///< one load for each colour
        RegionSearch parted;  ///< the anchor is a load of its own
        RegionSearch rest;    ///< without the anchor
        bool canPart;         ///< the anchor is significant, and not the only texel of its colour
    };

    /// A partition into two regions.
    struct Partition {
        int number;
        double both;  ///< sum over the regions of the smaller weight of the two colours; 0: the colours are separated
        std::array<Region, 2> regions;
    };

    Mode modeOf(int number) const;
    std::vector<Partition> partitions() const;
    void tryPartition(const Partition& partition);
    void measure(const TwoColours& two);
    void start();
    void tryOneRegion(const Mode& mode);
    void tryTwoRegions(const Mode& mode, int partition, const RegionBounds* bounds, std::array<Searches, 2>& searches);
    Region regionOf(std::uint32_t texels, int anchor) const;
    /// Returns every placement of a region's loads whose error is below the bound; only the best one if regions are independent.
    std::vector<Placement> placements(Searches& searches, const Mode& mode, bool isFirst, const RegionBounds* bounds, double bound) const;
    void partPlacements(Searches& searches, const Mode& mode, double bound, std::vector<Placement>& list) const;
    static bool needsOrder(const RegionSearch& search, const Mode& mode, const int* shares);
    void keepPlacement(RegionSearch& search, const Mode& mode, bool isFirst, Placement placement, double& bound,
                       std::vector<Placement>& list) const;
    double couple(const Mode& mode, const Placement& first, const Placement& second, std::array<Ends, 3>& firstEnds,
                  std::array<Ends, 3>& secondEnds) const;
    void keep(double error, const Mode& mode, int partition, const Placement* const* placements, const std::array<Ends, 3>* ends);
    void setIndices(int region, const Mode& mode, int partition, const Placement& placement);
    bool foundAll() const;

    bool isSigned_;
    EncodeOptions options_;
    std::array<ChannelError, 3> channels_;
    double least_ = 0;                                    ///< lower bound of the error of any block
    std::array<std::optional<RegionBounds>, 10> bounds_;  ///< for the modes with two regions
    std::array<double, 2> floor_{};                       ///< lower bounds of the weights in any region that has the colour
    double bestError_ = 0;
    Bc6hResult best_;
    const Block* block_ = nullptr;
    const TwoColours* two_ = nullptr;
};

}  // namespace lightcook::compress
