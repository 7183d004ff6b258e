// The layouts that were tried for a light map, beside the chosen one. For the table and the advice of a report.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "pipeline/report/page_parts.h"

namespace lightcook::pipeline {

inline std::uint64_t bytesOfCandidate(const Json& candidate) {
    return count(member(candidate, "bytes_gpu"));
}
/// Returns true if the scene's list of layouts lacks a candidate.
inline bool isExcluded(const Json& candidate) {
    return member(candidate, "excluded").is_boolean();
}

/// The figure by which the layouts of a light map are compared, diffuse and specular light alike: visible error where the map has a
/// limit on it, else rel_rms.
class ComparedError {
public:
    explicit ComparedError(const Json& asset) {
        const Json& limit = member(asset, "limit");
        const Json& candidates = list(asset, "trial_candidates");
        isVisible_ = member(limit, "max_visible").is_number() && std::ranges::all_of(candidates, [](const Json& each) {
                         return member(each, "visible_diffuse").is_number() && member(each, "visible_specular").is_number();
                     });
        limit_ = isVisible_ ? number(member(limit, "max_visible")) : limitOf(asset);
    }
    /// Returns the larger error of both kinds of light, which a limit on both applies to.
    [[nodiscard]] double of(const Json& candidate) const {
        return isVisible_ ? std::max(number(member(candidate, "visible_diffuse")), number(member(candidate, "visible_specular")))
                          : std::max(number(member(candidate, "diffuse")), number(member(candidate, "specular")));
    }
    [[nodiscard]] const char* name() const { return isVisible_ ? "visible error, p99" : "rel_rms"; }
    [[nodiscard]] double limit() const { return limit_; }
    [[nodiscard]] std::string text(double error) const { return isVisible_ ? humanNumber(error) : humanPercent(error); }

private:
    bool isVisible_ = false;
    double limit_ = 0;
};

/// Three of the candidates: the chosen one, the best of the smaller ones, and the smallest of the better ones. Null: there is none.
struct Alternatives {
    const Json *chosen = nullptr, *cheaper = nullptr, *better = nullptr;
    ComparedError error;

    /// The candidates are those of the asset, and live as long as it does.
    explicit Alternatives(const Json& asset) : error(asset) {
        const Json& candidates = list(asset, "trial_candidates");
        for (const Json& each : candidates)
            if (words(member(each, "layout")) == words(member(asset, "layout"))) chosen = &each;
        if (chosen == nullptr) return;
        for (const Json& each : candidates) {
            if (isExcluded(each)) continue;
            const std::uint64_t bytes = bytesOfCandidate(each);
            if (bytes < bytesOfCandidate(*chosen) && (cheaper == nullptr || error.of(each) < error.of(*cheaper))) cheaper = &each;
            if (error.of(each) < error.of(*chosen) && (better == nullptr || bytes < bytesOfCandidate(*better))) better = &each;
        }
    }
};

}  // namespace lightcook::pipeline
