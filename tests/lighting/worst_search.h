// A search for the input where a function errs most, for statements about errors that hold over ranges too large to try.
//
// Inputs are numbers in ranges. A start is drawn log-uniformly. From it one to three numbers are changed at a time: drawn anew, multiplied
// by 1 +- 2^-k, moved by one unit in the last place, set to an end or to another number (ties and cancellation), or all are scaled. A
// change that does not lower the ratio of error to statement is kept; after many in vain the search starts again. Like every search it
// proves nothing: it finds what examples miss.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tests/soak/soak.h"

namespace lightcook::test {

/// A number of the input. 0 < low < high unless it is linear.
struct SearchRange {
    enum class Kind {
        Positive,  ///< log-uniform
        Signed,    ///< likewise of either sign, or 0
        Linear     ///< uniform
    };
    double low, high;
    Kind kind = Kind::Positive;
};

struct SearchBudget {
    std::int64_t evaluations = 20000;
    double seconds = 0;  ///< more than 0: in place of a number of evaluations
    std::uint64_t seed = 1;
};
/// Returns the budget of one of `searches` of a soak test, which share its time.
inline SearchBudget soakBudget(int searches = 1) {
    return {0, std::max(0.1, soakSeconds() / searches), soakSeed() + 1};
}

struct WorstInput {
    double ratio = -std::numeric_limits<double>::infinity();  ///< of the error to the stated one: above 1, the statement is wrong
    std::vector<double> input;
    std::int64_t tried = 0;
};
inline std::ostream& operator<<(std::ostream& out, const WorstInput& worst) {
    out << worst.ratio << " of what is stated, in " << worst.tried << " inputs, at";
    const auto digits = out.precision(17);
    for (const double number : worst.input) out << ' ' << number;
    out.precision(digits);
    return out;
}

class WorstSearch {
public:
    WorstSearch(std::span<const SearchRange> ranges, const SearchBudget& budget)
        : ranges_(ranges.begin(), ranges.end()), budget_(budget), random_(budget.seed) {}

    /// ratioOf(input)  error over the stated one. NaN counts as infinite
    template <class Ratio>
    WorstInput run(const Ratio& ratioOf) {
        WorstInput worst;
        const auto start = std::chrono::steady_clock::now();
        const auto isDone = [&] {
            if (budget_.seconds <= 0) return worst.tried >= budget_.evaluations;
            return worst.tried % 64 == 0 &&
                   std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > budget_.seconds;
        };
        const auto measured = [&](const std::vector<double>& input) {
            double ratio = static_cast<double>(ratioOf(input));
            if (std::isnan(ratio)) ratio = std::numeric_limits<double>::infinity();
            ++worst.tried;
            if (ratio > worst.ratio) {
                worst.ratio = ratio;
                worst.input = input;
            }
            return ratio;
        };
        const std::size_t patience = 100 + 40 * ranges_.size();
        do {
            std::vector<double> at;
            for (const SearchRange& range : ranges_) at.push_back(drawn(range));
            double ratio = measured(at);
            for (std::size_t vain = 0; vain < patience && !isDone();) {
                std::vector<double> next = changed(at);
                const double found = measured(next);
                vain = found > ratio ? 0 : vain + 1;
                if (!(found >= ratio)) continue;
                ratio = found;
                at = std::move(next);
            }
        } while (!isDone());
        return worst;
    }

private:
    double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
    std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
    double drawn(const SearchRange& range) {
        if (range.kind == SearchRange::Kind::Linear) return range.low + (range.high - range.low) * uniform();
        const double size = std::exp2(std::log2(range.low) + (std::log2(range.high) - std::log2(range.low)) * uniform());
        if (range.kind == SearchRange::Kind::Positive) return size;
        const std::size_t sign = below(9);
        return sign == 0 ? 0 : sign < 5 ? size : -size;
    }
    static double within(const SearchRange& range, double value) {
        if (range.kind != SearchRange::Kind::Signed) return std::min(std::max(value, range.low), range.high);
        const double size = std::abs(value);
        if (size < range.low) return size < range.low / 2 ? 0 : std::copysign(range.low, value);
        return std::copysign(std::min(size, range.high), value);
    }
    std::vector<double> changed(std::vector<double> input) {
        if (below(12) == 0) {
            const double factor = std::exp2(std::round(8 * (uniform() - 0.5)) + (below(2) == 0 ? 0 : uniform()));
            for (std::size_t i = 0; i < input.size(); ++i)
                if (ranges_[i].kind != SearchRange::Kind::Linear) input[i] = within(ranges_[i], input[i] * factor);
            return input;
        }
        for (std::size_t count = 1 + below(3); count > 0; --count) {
            const std::size_t i = below(input.size());
            const SearchRange& range = ranges_[i];
            const bool isLinear = range.kind == SearchRange::Kind::Linear;
            double& value = input[i];
            const double share = std::exp2(-static_cast<double>(below(50))) * (below(2) == 0 ? 1 : -1) * uniform();
            switch (below(8)) {
                case 0:
                    value = drawn(range);
                    break;
                case 1:
                    value = below(2) == 0 ? range.low : range.high;
                    break;
                case 2:
                    value = std::nextafter(value, below(2) == 0 ? -HUGE_VAL : HUGE_VAL);
                    break;
                case 3:
                    value = (below(2) == 0 ? 1 : -1) * input[below(input.size())];
                    break;
                case 4:
                    value = isLinear ? std::round(value) : std::exp2(std::round(std::log2(std::abs(value))));
                    break;
                default:
                    value = isLinear ? value + share * (range.high - range.low) : value * (1 + share);
            }
            value = within(range, std::isfinite(value) ? value : range.low);
        }
        return input;
    }

    std::vector<SearchRange> ranges_;
    SearchBudget budget_;
    std::mt19937_64 random_;
};

/// Searches, prints what was found, and expects that the statement holds.
template <class Ratio>
WorstInput expectHolds(const std::string& statement, std::span<const SearchRange> ranges, const SearchBudget& budget,
                       const Ratio& ratioOf) {
    WorstInput worst = WorstSearch(ranges, budget).run(ratioOf);
    std::cout << statement << ": worst " << worst.ratio << " in " << worst.tried << " inputs\n";
    if (budget.seconds > 0) countInSoak(worst.tried, "inputs searched");
    EXPECT_LE(worst.ratio, 1) << statement << " at " << worst;
    return worst;
}

}  // namespace lightcook::test
