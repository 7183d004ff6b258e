// A loop on all cores, for tests that shade millions of samples.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace lightcook::test {

/// Calls body(index) for each of `count` on all cores.
template <class Body>
void onAllCores(std::size_t count, Body body) {
    std::atomic<std::size_t> next{0};
    std::vector<std::jthread> threads;
    for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
        threads.emplace_back([&] {
            for (std::size_t index = next++; index < count; index = next++) body(index);
        });
}

}  // namespace lightcook::test
