// The fits of learned layouts spread their loops over threads by this function. The module starts no thread and knows no scheduler.
#pragma once

#include <cstddef>
#include <functional>

namespace lightcook::compress {

/// Calls work(index) for each index in [0, count), in any order and on any threads, and returns after the last call.
using ParallelLoop = void (*)(std::size_t count, const std::function<void(std::size_t)>& work);

/// Sets the loop of the whole process. Without one, or with null, the calling thread does all the work. The results are the same.
void setParallelLoop(ParallelLoop loop);

}  // namespace lightcook::compress
