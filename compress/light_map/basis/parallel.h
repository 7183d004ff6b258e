// Parallel loops of the fit. Private to compress/.
#pragma once

#include <cstddef>
#include <functional>

#include "compress/parallel.h"

namespace lightcook::compress {

/// Runs the loop of setParallelLoop().
void runInParallel(std::size_t count, const std::function<void(std::size_t)>& work);

/// Calls work(index) for each index in [0, count), in parallel. Each call writes to what belongs to its index alone, so that the result
/// depends on neither the number of threads nor their order.
template <class Work>
void forEachInParallel(std::size_t count, Work work) {
    runInParallel(count, std::ref(work));
}

}  // namespace lightcook::compress
