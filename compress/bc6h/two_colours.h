// BC6H blocks of two colours, coded with the least error that the format has.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "compress/bc6h/search.h"
#include "compress/block/two_colours.h"

namespace lightcook::compress {

/// Every mode, every partition, every pair of places for the colours of each region, every pair of ends: cut wherever what is left cannot
/// beat the best so far.
class Bc6hTwoColours {
public:
    Bc6hTwoColours(bool isSigned, const EncodeOptions& options);
    Bc6hResult fit(const Block& block, const TwoColours& two);

private:
    /// Texels of one region that count.
    struct Region {
        std::array<double, 2> weight{};  ///< of each colour
        int anchorColour = -1;           ///< -1: the anchor does not count
        double anchorWeight = 0;
    };
    /// A region's places, and the ends that would be best for them if there were no other region.
    struct Placement {
        std::array<int, 2> index{};  ///< of each colour
        int anchorIndex = -1;        ///< of an anchor that has to part with its colour; -1: it need not
        const RegionSearch* search = nullptr;
        std::array<int, 3> shares{};  ///< of the search's loads
        std::array<Ends, 3> ends{};
        double error = 0;
    };
    /// What a mode asks of ends.
    struct Mode {
        int number = 0, regionCount = 1, indexBits = 0;
        bool transformed = false;
        const EndValues* values = nullptr;
        std::array<int, 3> reach{};                         ///< ends lie at most this far below the first, and one less above it
        std::array<Window, 3> firstWindows, secondWindows;  ///< of a region's ends: the second as long as nothing is known of the first
    };
    /// The searches of a region: all its texels in one or two loads, and those where the anchor parts with the others of its colour.
    struct Searches {
        explicit Searches(std::span<const ChannelError> channels, const Region& region);
        Region region;
        RegionSearch merged, parted, rest;  ///< rest: without the anchor
        bool canPart;
    };

    struct Partition {
        int number;
        double both;  ///< weight of texels beside heavier ones of the other colour
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
    /// Every placement of a region's loads whose error is below the bound; only the best where regions have nothing to do with one another.
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
    double least_ = 0;                                    ///< no block has a smaller error
    std::array<std::optional<RegionBounds>, 10> bounds_;  ///< of the modes with two regions
    std::array<double, 2> floor_{};                       ///< what a colour weighs at the least where a region has any of it
    double bestError_ = 0;
    Bc6hResult best_;
    const Block* block_ = nullptr;
    const TwoColours* two_ = nullptr;
};

}  // namespace lightcook::compress
