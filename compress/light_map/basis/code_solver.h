// The code of a texel of a learned layout: nonlinear least squares under the quadratic decode. Private to compress/.
//
// Minimises sum over channels of weight_c |U (P(u) - ratio)_c|^2 over u in [0, 1]^n, U the root of the metric (metric.h), by Levenberg and
// Marquardt with clamping: up to 8 steps of a 4 x 4 system, damping 1e-3 of the mean diagonal at first, times 0.2 after a step that
// reduces the error and times 10 after one that does not. Stops when a step gains less than 1e-4 of the error.
// A quadratic decode can have several local minima. search() therefore starts from the best of the cluster's seeds.
#pragma once

#include <span>
#include <vector>

#include "compress/light_map/basis/model.h"

namespace lightcook::compress {

struct SolvedCode {
    glm::vec4 code;
    float error;
};

/// The decode of a cluster under one metric: its tables multiplied by U, so that squared differences are costs. Texels of one cluster and
/// one normal share it.
class CodeSpace {
public:
    /// seeds  codes that search() may start from. The metric and the seeds have to outlive the object
    CodeSpace(const CodeTable& table, const BasisShape& shape, const Metric& metric, std::span<const glm::vec4> seeds = {});

    /// Returns the local minimum that the iteration reaches from `start`. target.metric must be this space's.
    SolvedCode solve(const BasisTarget& target, const glm::vec4& start) const;
    /// The same from the best of the seeds and the middle of the box.
    SolvedCode search(const BasisTarget& target);
    /// Returns the growth of the error with each channel: the diagonal of J' M J, summed over colours.
    glm::vec4 sensitivity(const BasisTarget& target, const glm::vec4& code) const;

private:
    BasisShape shape_;
    const Metric* metric_;
    std::span<const glm::vec4> seeds_;
    CodeTable table_{};                        ///< monomials beyond the shape's are zero
    std::vector<HigherByChannel> seedValues_;  ///< decoded candidates of search(); filled by its first call
};

}  // namespace lightcook::compress
