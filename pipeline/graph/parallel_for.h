// Parallel loops over indices, with progress and interrupts: merged in the order of the indices (foldInOrder, mapInOrder), or independent
// (forEachIndex).
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

/// Calls work(index), which returns a Result<T>, for each index in [0, count) on the threads of the arena, and merge(T) in the order of the
/// indices, one at a time. Work begins in that order too: only about one result a thread waits to be merged, and neighbouring rows are in
/// memory together. Returns the error of the lowest index that failed, or an interrupt.
template <class T, class Work, class Merge>
formats::Result<void> foldInOrder(int count, const ActionContext& context, const std::string& what, Work work, Merge merge) {
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
            context.report(what, static_cast<double>(++done) / count);
            const std::lock_guard lock(mutex);
            waiting.emplace(index, std::move(result));
            for (auto first = waiting.begin(); first != waiting.end() && first->first == merged && first->second; ++merged) {
                merge(std::move(*first->second));
                first = waiting.erase(first);
            }
        }
    };
    tbb::parallel_for(0, tbb::this_task_arena::max_concurrency(), [&](int) { workUntilDone(); });
    if (context.state.interrupted) return formats::failure(formats::ErrorCode::Interrupted, what, "interrupted");
    if (merged < count) return tl::make_unexpected(waiting.begin()->second.error());
    return {};
}

/// Does the same and returns all results, in order: for small ones.
template <class T, class Work>
formats::Result<std::vector<T>> mapInOrder(int count, const ActionContext& context, const std::string& what, Work work) {
    std::vector<T> values;
    const auto folded = foldInOrder<T>(count, context, what, work, [&](T&& value) { values.push_back(std::move(value)); });
    if (!folded) return tl::make_unexpected(folded.error());
    return values;
}

/// Returns the error of an action that was interrupted.
inline tl::unexpected<formats::Error> interrupted(const ActionContext& context) {
    return formats::failure(formats::ErrorCode::Interrupted, context.action.asset, "interrupted");
}

/// Calls work(index) for each index in [0, count), in no order. Returns false after an interrupt.
template <class Work>
bool forEachIndex(std::size_t count, const ActionContext& context, const std::string& what, Work work) {
    std::atomic<std::size_t> done{0};
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t index) {
        if (context.state.interrupted) return;
        work(index);
        context.report(what, static_cast<double>(++done) / static_cast<double>(count));
    });
    return !context.state.interrupted;
}

}  // namespace lightcook::pipeline
