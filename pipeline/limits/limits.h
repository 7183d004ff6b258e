// The limits on errors: a table with a row for each, and judge(), the only comparison of a figure with a limit.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

enum class Limit { Error, Visible, VisibleBound, Seam, WholeError, WholeVisible, ConverterError, ConverterVisible, ConverterVisibleBound };
inline constexpr std::size_t kLimitCount = 9;

/// Largest rel_rms that passes where no limit is given: any finite one of a right cook is smaller. Light that is lost has an error of 1.
inline constexpr double kNoErrorLimit = 2;

struct LimitInfo {
    Limit id;
    Limit held;                ///< limit of an asset that this one sets: itself; of converters Error, Visible or VisibleBound
    std::string_view name;     ///< key of a scene file; an option has dashes
    bool isFraction;           ///< else just noticeable differences
    std::string_view caption;  ///< of a document that has the limit
    std::string_view figure;   ///< "visible p99": the figure that it holds
    std::string_view words;    ///< the figure in an error line, with {} for its value
    int digits;                ///< of that value, at least

    /// Returns true for a limit that sets one of assets that are no light maps.
    bool isOfConverters() const { return id != held; }
};

/// Returns every limit, in the order of the enumeration.
std::span<const LimitInfo> allLimits();
const LimitInfo& info(Limit limit);
/// Returns the row whose limit sets a limit of assets that are no light maps.
const LimitInfo& converterLimit(Limit held);
/// Returns the name of the option that sets a limit: "--max-error".
std::string optionOf(const LimitInfo& limit);

/// The limits that an asset is held to, or that a table of a scene file sets.
class Limits {
public:
    Limits() = default;
    Limits(std::initializer_list<std::pair<Limit, std::optional<double>>> limits) {
        for (const auto& [limit, value] : limits) (*this)[limit] = value;
    }
    std::optional<double>& operator[](Limit limit) { return values_.at(static_cast<std::size_t>(limit)); }
    const std::optional<double>& operator[](Limit limit) const { return values_.at(static_cast<std::size_t>(limit)); }
    bool operator==(const Limits&) const = default;
    bool isAny(std::initializer_list<Limit> limits) const {
        return std::ranges::any_of(limits, [&](Limit limit) { return (*this)[limit].has_value(); });
    }

private:
    std::array<std::optional<double>, kLimitCount> values_;
};

/// The limits that the verification of an asset holds it to, all and those beside rel_rms.
inline constexpr std::initializer_list<Limit> kAssetLimits = {Limit::Error, Limit::Visible, Limit::VisibleBound, Limit::Seam},
                                              kFurtherAssetLimits = {Limit::Visible, Limit::VisibleBound, Limit::Seam};

/// Describes some limits as members of a struct that has them: each by its name, absent without a limit.
template <class Fields, Is<Limits> Self>
void describe(Fields& fields, Self& limits, std::initializer_list<Limit> held) {
    for (const Limit each : held) fields.optional(info(each).name, limits[each], between(0, HUGE_VAL), info(each).caption);
}

/// A measured value that a limit may hold.
struct Figure {
    Limit limit;
    double value = 0;
    std::string stage;    ///< "total", "mip 1"
    std::string shading;  ///< diffuse or specular; empty: neither
};

/// A figure beside its limit.
struct Check {
    Figure figure;
    double allowed = 0;

    /// Returns false also for a figure that is not a number.
    bool isKept() const { return figure.value <= allowed; }
    /// Returns the part of the limit that the figure uses: infinite for one that is not finite.
    double share() const;
};

/// Returns a check of each figure that has a limit, in their order.
std::vector<Check> judge(const std::vector<Figure>& figures, const Limits& limits);

bool areKept(const std::vector<Check>& checks);

/// Returns the check that uses the largest part of its limit; of equal ones the first. Empty without checks.
std::optional<Check> mostUsed(const std::vector<Check>& checks);
/// Returns its share(); 0 without checks.
double mostUsedShare(const std::vector<Check>& checks);

}  // namespace lightcook::pipeline
