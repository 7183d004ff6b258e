// The code of a texel of a learned layout: nonlinear least squares under the quadratic decode. Private to compress/.
//
// Minimises e' Q e over u in [0, 1]^n, where e is the error of the ratios under code u (the error of coefficient 0 is given, and the others
// can compensate for some of it), by Levenberg-Marquardt with clamping: up to 8 steps of a 4 x 4 system, damping 1e-3 of the mean diagonal
// at first, times 0.2 after a step that reduces the error and times 10 after one that does not. Stops when a step gains less than 1e-4 of
// the error. A quadratic decode can have several local minima. search() therefore starts from the best of the cluster's seeds.
#pragma once

#include <span>
#include <vector>

#include "compress/light_map/basis/model.h"

namespace lightcook::compress {

struct SolvedCode {
    glm::vec4 code;
    float error;
};

/// The decode of a cluster.
class CodeSpace {
public:
    /// seeds  codes that search() may start from; if empty, it starts from the middle of the box alone
    CodeSpace(const CodeTable& table, const BasisShape& shape, std::span<const glm::vec4> seeds = {});

    /// Returns the local minimum that the iteration reaches from `start`.
    SolvedCode solve(const BasisTarget& target, const glm::vec4& start) const;
    /// Returns the local minimum that the iteration reaches from the best of the seeds and the middle of the box.
    SolvedCode search(const BasisTarget& target) const;
    /// Returns the growth of the error with each channel: the diagonal of J' Q J.
    glm::vec4 sensitivity(const BasisTarget& target, const glm::vec4& code) const;

private:
    BasisShape shape_;
    CodeTable table_{};                     ///< monomials beyond the shape's are zero
    std::vector<glm::vec4> candidates_;     ///< of search()
    std::vector<HigherByChannel> decoded_;  ///< [candidate]
};

}  // namespace lightcook::compress
