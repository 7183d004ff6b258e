// BC7 at low effort: visits rows of blocks, one region first, then two regions for the blocks whose error is above a limit.
//
// Few blocks cause most of the squared error of an image, and two regions take three times as long as one. So only blocks above the limit
// get two regions; they are collected until they fill a vector.
#if defined(LIGHTCOOK_COMPRESS_BC7_FAST_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FAST_ROWS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FAST_ROWS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FAST_ROWS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "compress/bc7/fast/kernel-inl.h"
#include "compress/bc7/fast/pack.h"
#include "compress/bc7/search.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/texel_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7FastRows : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero;
    static constexpr std::size_t kLanes = hn::MaxLanes(D());

public:
    Bc7FastRows(const Bc7FastSearch& search, const EncodeOptions& options, Bc7OneColour* oneColour)
        : search_(search), fit_(search, options), oneColour_(oneColour) {
        // Lanes that are never filled need weights too.
        for (auto& row : queue_.texels) std::fill(std::begin(row), std::end(row), 0.0f);
        for (auto& row : queue_.weights) std::fill(std::begin(row), std::end(row), 1.0f);
    }

    /// Encodes all blocks. Returns true if a value was clamped into the range of the format.
    bool run(const TexelRows& rows, std::byte* out) {
        bool clamped = false;
        forEachVector<D>(rows,
                         [&](const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights, std::size_t count) {
                             clamped |= fit_.runOneRegion(texels, weights, count, out);
                             visit(texels, weights, count, out);
                             out += 16 * count;
                         });
        flush();
        return clamped;
    }

private:
    /// Blocks that wait for the fit of two regions.
    struct Queue {
        HWY_ALIGN float texels[4][16 * kLanes];
        HWY_ALIGN float weights[4][4 * kLanes];
        HWY_ALIGN float error[kLanes];
        std::array<std::byte*, kLanes> out;
        std::size_t count = 0;
    };

    /// Encodes blocks of one colour, and puts blocks above the limit into the queue.
    void visit(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights, std::size_t count, std::byte* out) {
        const auto& loaded = fit_.texels();
        const M constant = loaded.constant;
        if (!hn::AllFalse(D(), constant)) {
            HWY_ALIGN float value[4][kLanes], isConstant[kLanes];
            for (std::size_t c = 0; c < 4; ++c) hn::Store(loaded.valueOf(c, 0), D(), value[c]);
            hn::Store(hn::IfThenElseZero(constant, set(1.0f)), D(), isConstant);
            for (std::size_t lane = 0; lane < count; ++lane)
                if (isConstant[lane] > 0) oneColour_({value[0][lane], value[1][lane], value[2][lane], value[3][lane]}, out + 16 * lane);
        }
        const F limit = loaded.total * set(4 * search_.twoRegionsAbove * search_.twoRegionsAbove);
        const M poor = hn::AndNot(hn::Or(constant, loaded.nothing), fit_.error() > limit);
        if (search_.partitions == 0 || hn::AllFalse(D(), poor)) return;
        HWY_ALIGN float error[kLanes];
        hn::Store(hn::IfThenElseZero(poor, fit_.error()), D(), error);
        for (std::size_t lane = 0; lane < count; ++lane) {
            if (!(error[lane] > 0)) continue;
            for (std::size_t y = 0; y < 4; ++y) {
                std::copy_n(texels[y] + 16 * lane, 16, queue_.texels[y] + 16 * queue_.count);
                if (weights)
                    std::copy_n((*weights)[y] + 4 * lane, 4, queue_.weights[y] + 4 * queue_.count);
                else
                    std::fill_n(queue_.weights[y] + 4 * queue_.count, 4, 1.0f);
            }
            queue_.error[queue_.count] = error[lane];
            queue_.out[queue_.count++] = out + 16 * lane;
            if (queue_.count == kLanes) flush();
        }
    }
    void flush() {
        if (queue_.count == 0) return;
        const std::array<const float*, 4> texels = {queue_.texels[0], queue_.texels[1], queue_.texels[2], queue_.texels[3]},
                                          weights = {queue_.weights[0], queue_.weights[1], queue_.weights[2], queue_.weights[3]};
        fit_.runTwoRegions(texels, weights, hn::Load(D(), queue_.error), {queue_.out.data(), queue_.count});
        queue_.count = 0;
    }

    const Bc7FastSearch& search_;
    Bc7Fast<D> fit_;
    Bc7OneColour* oneColour_;
    Queue queue_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
