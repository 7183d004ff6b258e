// Time and counts of the tests of ./dev soak (tests/soak/run.py).
//
// LIGHTCOOK_SOAK_SECONDS is the time of a whole process of tests. Each test may take an equal part of what is left, so that the time of
// tests that end early goes to those after them. clock.cpp skips tests that would begin later.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <string>

namespace lightcook::test {

struct SoakClock {
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();  ///< of the process
    int testsBegun = 0;
};
inline SoakClock soakClock;

/// Returns the time that the process has left [s]. Nothing: LIGHTCOOK_SOAK_SECONDS is not set.
inline std::optional<double> soakSecondsLeft() {
    const char* asked = std::getenv("LIGHTCOOK_SOAK_SECONDS");
    if (asked == nullptr) return std::nullopt;
    return std::atof(asked) - std::chrono::duration<double>(std::chrono::steady_clock::now() - soakClock.start).count();
}

/// Returns the time that the test may take [s]; 5 where LIGHTCOOK_SOAK_SECONDS is not set.
inline double soakSeconds() {
    const std::optional<double> left = soakSecondsLeft();
    if (!left) return 5;
    return std::max(0.0, *left) / std::max(1, testing::UnitTest::GetInstance()->test_to_run_count() - soakClock.testsBegun + 1);
}

/// Returns the seed of random cases: LIGHTCOOK_SOAK_SEED, or 1.
inline std::uint64_t soakSeed() {
    const char* asked = std::getenv("LIGHTCOOK_SOAK_SEED");
    return asked == nullptr ? 1 : std::strtoull(asked, nullptr, 10);
}

/// Measures the time of a test from its construction.
class SoakTime {
public:
    bool isOver() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count() >= seconds_; }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    double seconds_ = soakSeconds();
};

/// Prints a count that run.py adds to those of the same unit ("blocks").
inline void countInSoak(std::int64_t count, const std::string& unit) {
    std::cout << "soak: " << count << ' ' << unit << std::endl;
}

/// Calls body(seed) with one seed after another, once at least, until the time of the test is over or it has failed.
/// unit  what a call tries `each` of
template <class Body>
void repeatInSoak(const std::string& unit, std::int64_t each, const Body& body) {
    const SoakTime time;
    std::int64_t count = 0;
    std::uint64_t seed = soakSeed();
    do {
        SCOPED_TRACE("LIGHTCOOK_SOAK_SEED=" + std::to_string(seed));
        body(seed++);
        count += each;
    } while (!time.isOver() && !testing::Test::HasFailure());
    countInSoak(count, unit);
}

}  // namespace lightcook::test
