// Parallel loops of the fit. Private to compress/.
#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>

namespace lightcook::compress {

/// Calls work(index) for each index in [0, count), on the threads of the caller's TBB arena. Each call writes to what belongs to its index
/// alone, so that the result depends on neither the number of threads nor their order.
template <class Work>
void forEachInParallel(std::size_t count, Work work) {
    tbb::parallel_for(std::size_t{0}, count, work);
}

}  // namespace lightcook::compress
