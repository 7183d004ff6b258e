// Work in pieces spread over threads: the bands or strips of a light map, merged in the order of the rows, and others in no order.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <map>
#include <mutex>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Calls work(index) for index 0 .. count - 1, each a Result<T>, on the threads of the arena, and merge(T) with each in the order of their
/// indices, one at a time. Indices are begun in that order: what is in flight or waits to be merged is about one a thread, and neighbours
/// find each other's rows in memory. The first error in the order of indices is the one that is told; an interrupt is one too.
template <class T, class Work, class Merge>
formats::Result<void> foldBands(int count, const ActionContext& context, const std::string& what, Work work, Merge merge) {
    std::atomic<int> next{0}, done{0}, lowestFailure{count};
    std::mutex mutex;
    std::map<int, formats::Result<T>> waiting;
    int merged = 0;
    const auto workUntilDone = [&] {
        for (int index = next++; index < count; index = next++) {
            if (index > lowestFailure || context.state.interrupted) return;
            formats::Result<T> result = work(index);
            int lowest = lowestFailure;
            while (!result && index < lowest && !lowestFailure.compare_exchange_weak(lowest, index)) {
            }
            if (context.state.progress) context.state.progress(what, static_cast<double>(++done) / count);
            const std::lock_guard lock(mutex);
            waiting.emplace(index, std::move(result));
            for (auto first = waiting.begin(); first != waiting.end() && first->first == merged && first->second; ++merged) {
                merge(std::move(*first->second));
                first = waiting.erase(first);
            }
        }
    };
    tbb::parallel_for(0, tbb::this_task_arena::max_concurrency(), [&](int) { workUntilDone(); });
    if (context.state.interrupted) return formats::failure(formats::ErrorCode::Interrupted, what, "found an interrupt, expected to finish");
    if (merged < count) return tl::make_unexpected(waiting.begin()->second.error());
    return {};
}

/// The same, all results kept: for small ones.
template <class T, class Work>
formats::Result<std::vector<T>> forEachBand(int count, const ActionContext& context, const std::string& what, Work work) {
    std::vector<T> values;
    const auto folded = foldBands<T>(count, context, what, work, [&](T&& value) { values.push_back(std::move(value)); });
    if (!folded) return tl::make_unexpected(folded.error());
    return values;
}

/// What an action ends with after an interrupt.
inline tl::unexpected<formats::Error> interrupted(const ActionContext& context) {
    return formats::failure(formats::ErrorCode::Interrupted, context.action.asset, "found an interrupt, expected to finish");
}

/// work(index) for each of count pieces, in no order; false after an interrupt.
template <class Work>
bool forEachPiece(std::size_t count, const ActionContext& context, const std::string& what, Work work) {
    std::atomic<std::size_t> done{0};
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t index) {
        if (context.state.interrupted) return;
        work(index);
        if (context.state.progress) context.state.progress(what, static_cast<double>(++done) / static_cast<double>(count));
    });
    return !context.state.interrupted;
}

}  // namespace lightcook::pipeline
