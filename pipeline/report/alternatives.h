// The layouts that were tried for a light map, beside the chosen one. For the table and the advice of a report.
#pragma once

#include <algorithm>
#include <cstdint>

#include "pipeline/report/page_parts.h"

namespace lightcook::pipeline {

inline std::uint64_t bytesOfCandidate(const Json& candidate) {
    return count(member(candidate, "bytes_gpu"));
}
/// Returns the larger of both errors, which a limit on both applies to.
inline double worseError(const Json& candidate) {
    return std::max(number(member(candidate, "diffuse")), number(member(candidate, "specular")));
}
/// Returns true if the scene's list of layouts lacks a candidate.
inline bool isExcluded(const Json& candidate) {
    return member(candidate, "excluded").is_boolean();
}

/// Three of the candidates: the chosen one, the best of the smaller ones, and the smallest of the better ones. Null: there is none.
struct Alternatives {
    const Json *chosen = nullptr, *cheaper = nullptr, *better = nullptr;

    /// The candidates are those of the asset, and live as long as it does.
    explicit Alternatives(const Json& asset) {
        const Json& candidates = list(asset, "trial_candidates");
        for (const Json& each : candidates)
            if (words(member(each, "layout")) == words(member(asset, "layout"))) chosen = &each;
        if (chosen == nullptr) return;
        for (const Json& each : candidates) {
            if (isExcluded(each)) continue;
            const std::uint64_t bytes = bytesOfCandidate(each);
            if (bytes < bytesOfCandidate(*chosen) && (cheaper == nullptr || worseError(each) < worseError(*cheaper))) cheaper = &each;
            if (worseError(each) < worseError(*chosen) && (better == nullptr || bytes < bytesOfCandidate(*better))) better = &each;
        }
    }
};

}  // namespace lightcook::pipeline
