// `cook --patch` encodes a bake that changed a little with the plan of the bake before it. KeptMap names that plan, and has its keys.
#pragma once

#include <cmath>
#include <string>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

/// Kept keys serve while those of the bake are within this factor.
inline constexpr double kMostKeyDrift = 1.01;

struct KeptMap {
    std::string plan;                ///< CookedAsset::plan
    double key = 0, displayKey = 0;  ///< of the bake that the plan was made for (verify::LightMapKey)

    /// Returns true if the keys of a bake are close to the kept ones.
    bool serves(double keyOfBake, double displayKeyOfBake) const {
        const auto isClose = [](double a, double b) { return a <= kMostKeyDrift * b && b <= kMostKeyDrift * a; };
        return isClose(key, keyOfBake) && isClose(displayKey, displayKeyOfBake);
    }
    bool operator==(const KeptMap&) const = default;
};
template <class Fields, Is<KeptMap> Self>
void describe(Fields& fields, Self& kept) {
    fields.required("plan", kept.plan, "digest of the plan: ranges, tables, tiles with detail");
    fields.required("key", kept.key, between(0, HUGE_VAL), "log-average luminance that errors are relative to");
    fields.required("display_key", kept.displayKey, between(0, HUGE_VAL), "that which the display is exposed for");
}

/// Describes the parameter of a verification.
template <class Fields, class Kept>
void describeKeptKeys(Fields& fields, Kept& kept) {
    fields.optional("kept", kept,
                    "after `cook --patch`: keys of an earlier bake, to which errors are relative; those of the bake differ by 1 % at most");
}

}  // namespace lightcook::pipeline
