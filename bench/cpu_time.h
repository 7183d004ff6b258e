// Processor time, which other work on the machine does not change.
#pragma once

#include <algorithm>
#include <ctime>
#include <limits>

namespace lightcook::bench {

/// Returns the processor time that this process has used, all threads together [s].
inline double processSeconds() {
    timespec now{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Returns the processor time of work() [s], the best of so many runs (at least one).
template <class Work>
double cpuSeconds(int runs, Work&& work) {
    double best = std::numeric_limits<double>::infinity();
    for (int run = 0; run < runs; ++run) {
        const double start = processSeconds();
        work();
        best = std::min(best, processSeconds() - start);
    }
    return best;
}

}  // namespace lightcook::bench
