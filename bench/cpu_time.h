// Processor time of a piece of work, so that other work on the machine does not count.
#pragma once

#include <algorithm>
#include <ctime>
#include <limits>

namespace lightcook::bench {

/// CPU seconds of the whole process, best of the runs (at least one).
template <class Work>
double cpuSeconds(int runs, Work&& work) {
    double best = std::numeric_limits<double>::infinity();
    for (int run = 0; run < runs; ++run) {
        const std::clock_t begin = std::clock();
        work();
        best = std::min(best, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    }
    return best;
}

}  // namespace lightcook::bench
