// Which code a texel of a learned layout should store: least squares under a decode that bends. Private to compress/.
#pragma once

#include <span>
#include <vector>

#include "compress/light_map/basis/model.h"

namespace lightcook::compress {

struct SolvedCode {
    glm::vec4 code;
    float error;
};

/// A cluster's decode as one metric sees it: tables turned so that squared differences are costs. Texels of one cluster and one normal
/// share it.
class CodeSpace {
public:
    /// seeds: codes to search from, if that is wanted. The metric and the seeds have to outlive the space.
    CodeSpace(const CodeTable& table, const BasisShape& shape, const Metric& metric, std::span<const glm::vec4> seeds = {});

    /// The code in [0, 1]^n of least error, from a start on (Levenberg and Marquardt). Takes `target` to have this space's metric.
    SolvedCode solve(const BasisTarget& target, const glm::vec4& start) const;
    /// The same from the best of the seeds, or from the middle of the box. A quadratic can be left by a wrong way.
    SolvedCode search(const BasisTarget& target);
    /// How the error grows with each channel: diagonal of J' M J, summed over colours.
    glm::vec4 sensitivity(const BasisTarget& target, const glm::vec4& code) const;

private:
    BasisShape shape_;
    const Metric* metric_;
    std::span<const glm::vec4> seeds_;
    CodeTable table_{};                        ///< monomials that the shape has not are zero
    std::vector<HigherByChannel> seedValues_;  ///< what the seeds decode to: made by the first search
};

}  // namespace lightcook::compress
