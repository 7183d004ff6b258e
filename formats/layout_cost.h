// Settings of the choice of light-map layouts: the cost that it keeps small, limits on the decode, and the layouts that an engine reads.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/light_map_layout.h"

namespace lightcook::formats {

/// "auto" takes the cheapest of the layouts that keep the limits.
enum class LayoutCost { Bytes, Fetches };

struct LayoutCostInfo {
    LayoutCost id;
    std::string_view name;     ///< as in `[output] cost`
    std::string_view caption;  ///< for help texts and documents
};

inline constexpr std::array kLayoutCosts = {
    LayoutCostInfo{LayoutCost::Bytes, "bytes", "GPU memory"},
    LayoutCostInfo{LayoutCost::Fetches, "taps", "texture fetches of a sample; of layouts with as many, GPU memory"},
};
static_assert(isCompleteTable(kLayoutCosts, LayoutCost::Fetches));

/// Returns every cost, the default first.
inline std::span<const LayoutCostInfo> allLayoutCosts() {
    return kLayoutCosts;
}

inline const LayoutCostInfo& info(LayoutCost cost) {
    return kLayoutCosts[static_cast<std::size_t>(cost)];
}

/// Limits on the decode in the shader, and its filter.
struct DecodeLimits {
    std::optional<int> maxFetches = {};    ///< texture fetches of a sample
    std::optional<int> maxDecodeOps = {};  ///< scalar multiply-adds of a sample
    /// Empty: the usual one of the layout, or that of the hardware if the usual one costs too much.
    std::optional<LightMapFilter> filter = {};
    std::optional<LightMapFilter> preferred = {};  ///< the usual one of every layout that may have it

    constexpr LightMapFilter filterOf(const LightMapLayoutInfo& layout) const {
        const LightMapFilter usual = preferred && layout.mayHave(*preferred) ? *preferred : layout.usualFilter();
        return layout.filterFor(filter.value_or(isWithin(layout, usual) ? usual : LightMapFilter::Hardware));
    }
    constexpr int fetchesOf(const LightMapLayoutInfo& layout) const { return layout.fetchCount(filterOf(layout)); }
    constexpr int operationsOf(const LightMapLayoutInfo& layout) const { return layout.operations(filterOf(layout)); }
    constexpr bool allow(const LightMapLayoutInfo& layout) const {
        return isWithin(layout, filterOf(layout)) && (!filter || layout.mayHave(*filter));
    }
    friend bool operator==(const DecodeLimits&, const DecodeLimits&) = default;

private:
    constexpr bool isWithin(const LightMapLayoutInfo& layout, LightMapFilter asked) const {
        const int fetches = layout.fetchCount(asked), operations = layout.operations(asked);
        return fetches <= maxFetches.value_or(fetches) && operations <= maxDecodeOps.value_or(operations);
    }
};

/// Names of the layouts that "auto" may take. Empty: there is no list, and every layout that a trial measures may be taken.
using LayoutList = std::vector<std::string>;

/// Returns true if the list is empty or has the layout.
inline bool mayTake(const LayoutList& list, const LightMapLayoutInfo& layout) {
    return list.empty() || std::ranges::find(list, layout.name) != list.end();
}

/// Returns true if "auto" may take the layout: the list has it, or without a list some trial measures it.
inline bool isCandidate(const LayoutList& list, const LightMapLayoutInfo& layout) {
    return list.empty() ? layout.trialLayout.has_value() : mayTake(list, layout);
}

}  // namespace lightcook::formats
