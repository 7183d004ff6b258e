#include "compress/light_map/basis/parallel.h"

#include <atomic>

namespace lightcook::compress {
namespace {

void loopHere(std::size_t count, const std::function<void(std::size_t)>& work) {
    for (std::size_t index = 0; index < count; ++index) work(index);
}

std::atomic<ParallelLoop> parallelLoop = loopHere;

}  // namespace

void setParallelLoop(ParallelLoop loop) {
    parallelLoop = loop != nullptr ? loop : loopHere;
}

void runInParallel(std::size_t count, const std::function<void(std::size_t)>& work) {
    parallelLoop.load()(count, work);
}

}  // namespace lightcook::compress
