// Work on the bands of a light map: spread over threads, merged in the order of the rows.
#pragma once

#include <tbb/parallel_for.h>

#include <atomic>
#include <optional>
#include <vector>

#include "formats/error.h"
#include "pipeline/action.h"

namespace pipeline {

/// Calls work(index) for index 0 .. bandCount - 1 on the threads of the arena. Bands in flight are at most one a thread: that, not the map,
/// bounds memory. The first error in the order of bands is the one that is told; an interrupt is one too.
template <class T, class Work>
formats::Result<std::vector<T>> forEachBand(int bandCount, const ActionContext& context, const std::string& what, Work work) {
    std::vector<std::optional<formats::Result<T>>> results(static_cast<std::size_t>(bandCount));
    std::atomic<int> done{0};
    std::atomic<int> lowestFailure{bandCount};
    tbb::parallel_for(
        tbb::blocked_range<int>(0, bandCount, 1),
        [&](const tbb::blocked_range<int>& range) {
            for (int index = range.begin(); index < range.end(); ++index) {
                if (index > lowestFailure || context.state.interrupted) return;
                auto& result = results[static_cast<std::size_t>(index)];
                result = work(index);
                int lowest = lowestFailure;
                while (!*result && index < lowest && !lowestFailure.compare_exchange_weak(lowest, index)) {
                }
                if (context.state.progress) context.state.progress(what, static_cast<double>(++done) / bandCount);
            }
        },
        tbb::simple_partitioner());
    if (context.state.interrupted) return formats::failure(formats::ErrorCode::Interrupted, what, "found an interrupt, expected to finish");
    std::vector<T> values;
    for (auto& result : results)
        if (result && !*result) return tl::make_unexpected(result->error());
    for (auto& result : results) values.push_back(std::move(**result));
    return values;
}

}  // namespace pipeline
