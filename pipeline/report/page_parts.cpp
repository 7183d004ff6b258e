#include "pipeline/report/page_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lightcook::pipeline {
namespace {

bool isOver(double figure, double limit) {
    return !std::isfinite(figure) || figure > limit;
}

/// Returns a member of `object` over a thin bar that is full at its limit; without a limit the member alone.
/// content  of the member
Html limitedFigure(Html content, const Json& object, const char* name, double limit) {
    const double figure = number(member(object, name));
    const bool isMeasured = object.is_object() && object.contains(name);
    if (isMeasured && limit > 0) {
        const double share = std::isfinite(figure) ? std::clamp(figure / limit, 0.0, 1.0) : 1.0;
        content += element("span", {{"class", "meter"}}, element("i", {{"style", fmt::format("width:{:.1f}%", 100 * share)}}, {}));
    }
    return element("td", {{"class", isMeasured && isOver(figure, limit) ? "num over" : "num"}}, content);
}

}  // namespace

const Json& member(const Json& object, const char* key) {
    static const Json kAbsent;
    if (!object.is_object()) return kAbsent;
    const auto found = object.find(key);
    return found == object.end() ? kAbsent : *found;
}

const Json& list(const Json& object, const char* key) {
    static const Json kEmpty = Json::array();
    const Json& value = member(object, key);
    return value.is_array() ? value : kEmpty;
}

std::string words(const Json& value) {
    if (value.is_null()) return "";
    return value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

double number(const Json& value) {
    const double found = value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
    return std::isfinite(found) ? found : std::numeric_limits<double>::quiet_NaN();
}

std::uint64_t count(const Json& value) {
    if (value.is_number_unsigned()) return value.get<std::uint64_t>();
    if (value.is_number_integer()) return static_cast<std::uint64_t>(std::max<std::int64_t>(0, value.get<std::int64_t>()));
    return value.is_number_float() && value.get<double>() > 0 && value.get<double>() < 1e18
               ? static_cast<std::uint64_t>(value.get<double>())
               : 0;
}

bool passed(const Json& object) {
    const Json& value = member(object, "passed");
    return value.is_boolean() && value.get<bool>();
}

Html word(const char* plain) {
    return text(plain);
}

Html withTitle(const std::string& shown, const std::string& exact) {
    return element("span", {{"title", exact}}, text(shown));
}

Html bytesMarkup(std::uint64_t bytes) {
    return withTitle(humanBytes(bytes), groupedCount(bytes) + " bytes");
}

Html secondsMarkup(const Json& seconds) {
    return withTitle(seconds.is_null() ? kDash : humanSeconds(number(seconds)), exactNumber(number(seconds)) + " s");
}

Html percentMarkup(double ratio) {
    return withTitle(humanPercent(ratio), exactNumber(ratio));
}

Html numberCell(const Html& content, const Attributes& more) {
    Attributes attributes = {{"class", "num"}};
    attributes.insert(attributes.end(), more.begin(), more.end());
    return element("td", attributes, content);
}

Html headCell(const char* name, const char* kind, const Attributes& more) {
    Attributes attributes = {{"scope", "col"}, {"class", kind}};
    attributes.insert(attributes.end(), more.begin(), more.end());
    return element("th", attributes, word(name));
}

Html table(const char* kind, const Html& head, const Html& body) {
    const Html grid = element("table", {{"class", kind}}, element("thead", head) + element("tbody", body));
    return element("div", {{"class", "scroll"}}, grid);
}

Html card(const char* title, const Html& content) {
    return element("section", {{"class", "card"}}, element("h2", word(title)) + content);
}

Html verdictChip(bool isPassed) {
    return element("span", {{"class", isPassed ? "verdict passed" : "verdict failed"}}, word(isPassed ? "✓ passed" : "✗ failed"));
}

Html fact(const char* name, const Html& value) {
    return element("div", element("dt", word(name)) + element("dd", value));
}

Html swatch(const std::string& kind) {
    return element("span", {{"class", "swatch"}, {"style", "background:" + kindColor(kind)}}, {});
}

std::string assetAnchor(std::size_t index) {
    return fmt::format("asset-{}", index + 1);
}

std::string sizeWords(const Json& asset) {
    const std::uint64_t width = count(member(asset, "width")), height = count(member(asset, "height"));
    if (width == 0 || height == 0) return "";
    return fmt::format("{} × {}{}", width, height, member(asset, "kind") == "cubemap" ? " × 6" : "");
}

const Json& lastStage(const Json& asset) {
    static const Json kNone;
    const Json& stages = list(asset, "stages");
    return stages.empty() ? kNone : stages.back();
}

std::vector<const char*> shadingsOf(const Json& asset) {
    std::vector<const char*> shadings;
    for (const char* shading : kShadings)
        if (std::ranges::any_of(list(asset, "stages"), [&](const Json& stage) {
                // Figures of light that the asset does not affect are 0, without visible errors and places.
                const Json& figures = member(member(stage, "error"), shading);
                const auto isObject = [&](const char* name) { return member(figures, name).is_object(); };
                if (std::ranges::any_of(std::array{"visible", "sampled_at", "bound_at"}, isObject)) return true;
                return std::ranges::any_of(std::array{"rel_rms", "p99", "max_sampled", "max_bound"}, [&](const char* name) {
                    return figures.is_object() && figures.contains(name) && number(member(figures, name)) != 0;
                });
            }))
            shadings.push_back(shading);
    if (shadings.empty()) shadings.assign(kShadings.begin(), kShadings.end());
    return shadings;
}

double limitOf(const Json& asset) {
    return number(member(member(asset, "limit"), "value"));
}

Html figureMarkup(const Json& figures, const char* name) {
    const Json& value = member(figures, name);
    if (!figures.is_object() || !figures.contains(name)) return withTitle(kDash, "not measured");
    return percentMarkup(number(value));
}

Html visibleMarkup(const Json& figures, const char* name) {
    return visibleNumber(member(figures, "visible"), name);
}

Html visibleNumber(const Json& object, const char* name) {
    if (!object.is_object() || !object.contains(name)) return withTitle(kDash, "not measured");
    const double value = number(member(object, name));
    return withTitle(std::isfinite(value) ? fmt::format("{:.2f}", value) : "not finite", exactNumber(value));
}

Html limitedCell(const Json& figures, double limit) {
    return limitedFigure(figureMarkup(figures, "rel_rms"), figures, "rel_rms", limit);
}

Html limitedVisibleCell(const Json& figures, const char* name, const Json& asset) {
    const char* const limit = name == std::string_view("bound") ? "max_visible_bound" : "max_visible";
    return limitedFigure(visibleMarkup(figures, name), member(figures, "visible"), name, number(member(member(asset, "limit"), limit)));
}

}  // namespace lightcook::pipeline
