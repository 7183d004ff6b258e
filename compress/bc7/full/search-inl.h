// BC7 above low effort: for each block the candidates of least predicted error, which are then polished; the best result wins.
//
// Candidates of all blocks are sorted by mode, so that the blocks in the lanes of a vector are polished alike.
#if defined(LIGHTCOOK_COMPRESS_BC7_FULL_SEARCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FULL_SEARCH_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FULL_SEARCH_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FULL_SEARCH_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "compress/bc7/full/candidates-inl.h"
#include "compress/bc7/full/polish-inl.h"
#include "compress/bc7/search.h"
#include "compress/block/block.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7FullSearch {
public:
    Bc7FullSearch(const Bc7Search& search, const EncodeOptions& options)
        : search_(search), candidates_(search, options), polish_(search, options) {}

    /// Encodes blocks, none of which has only one colour.
    void run(std::span<const Block* const> blocks, Bc7Result* found) {
        for (auto& group : groups_) group.clear();
        for (std::size_t first = 0; first < blocks.size(); first += kLanes) sortCandidates(blocks, first);
        for (std::size_t i = 0; i < blocks.size(); ++i) found[i].error = -1;
        for (const auto& group : groups_)
            for (std::size_t first = 0; first < group.size(); first += kLanes) polish(blocks, group, first, found);
    }

private:
    static constexpr std::size_t kLanes = hn::MaxLanes(D());
    struct Work {
        std::size_t block;
        std::int32_t number;  ///< of a Bc7Candidate
    };

    /// Finds the candidates of a vector of blocks, the last of which is repeated to fill it.
    void sortCandidates(std::span<const Block* const> blocks, std::size_t first) {
        std::array<const Block*, kLanes> lanes;
        for (std::size_t lane = 0; lane < kLanes; ++lane) lanes[lane] = blocks[std::min(first + lane, blocks.size() - 1)];
        candidates_.find(lanes.data());
        std::array<std::int32_t, kLanes * Bc7Search::kMostPolished> numbers;
        candidates_.store(numbers.data());
        const auto each = static_cast<std::size_t>(search_.polished);
        for (std::size_t i = first; i < std::min(first + kLanes, blocks.size()); ++i)
            for (std::size_t k = 0; k < each; ++k)
                if (const std::int32_t number = numbers[(i - first) * each + k]; number != Bc7Candidate::kNone)
                    groups_[static_cast<std::size_t>(number) % kGroups].push_back({i, number});
    }
    void polish(std::span<const Block* const> blocks, std::span<const Work> group, std::size_t first, Bc7Result* found) {
        std::array<const Block*, kLanes> lanes;
        std::array<std::int32_t, kLanes> numbers;
        std::array<Bc7Result, kLanes> results;
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const Work& work = group[std::min(first + lane, group.size() - 1)];
            lanes[lane] = blocks[work.block];
            numbers[lane] = work.number;
        }
        polish_.run(lanes.data(), numbers.data(), results.data());
        for (std::size_t i = first; i < std::min(first + kLanes, group.size()); ++i) {
            Bc7Result& best = found[group[i].block];
            if (best.error < 0 || results[i - first].error < best.error) best = results[i - first];
        }
    }

    const Bc7Search& search_;
    Bc7Candidates<D> candidates_;
    Bc7Polish<D> polish_;
    static constexpr std::size_t kGroups = std::size_t{1}
                                           << Bc7Candidate::kPartitionShift;  ///< candidates that differ in more than the partition
    std::array<std::vector<Work>, kGroups> groups_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
