// Runs a kernel, which encodes one block in each lane of a vector, over any number of blocks.
#if defined(LIGHTCOOK_COMPRESS_FIT_BLOCKS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_FIT_BLOCKS_INL_H_
#undef LIGHTCOOK_COMPRESS_FIT_BLOCKS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_FIT_BLOCKS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "compress/block/block.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Calls fit(blocks, results) for groups of MaxLanes(D()) blocks and copies the results to found. The last group is filled up with
/// repeats of the last block.
template <class D, class Result, class Fit>
void fitBlocks(std::span<const Block* const> blocks, Result* found, const Fit& fit) {
    constexpr std::size_t kLanes = hn::MaxLanes(D());
    std::array<const Block*, kLanes> lanes;
    std::array<Result, kLanes> results;
    for (std::size_t first = 0; first < blocks.size(); first += kLanes) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) lanes[lane] = blocks[std::min(first + lane, blocks.size() - 1)];
        fit(lanes.data(), results.data());
        std::copy_n(results.begin(), std::min(kLanes, blocks.size() - first), found + first);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
