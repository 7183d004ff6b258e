// Skips the tests that begin when the process has no time left for the soak. Part of every test program.
#include "tests/soak/soak.h"

namespace lightcook::test {
namespace {

class Clock : public testing::EmptyTestEventListener {
    void OnTestStart(const testing::TestInfo&) override {
        // The first test runs in any time: a process has tried something.
        if (++soakClock.testsBegun > 1 && soakSecondsLeft().value_or(1) <= 0) GTEST_SKIP() << "no time left";
    }
};
// GoogleTest deletes it.
[[maybe_unused]] const bool isAdded = (testing::UnitTest::GetInstance()->listeners().Append(new Clock), true);

}  // namespace
}  // namespace lightcook::test
