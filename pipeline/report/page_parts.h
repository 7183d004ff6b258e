// What the sections of report.html are put together from: readings of report.json that tolerate what is absent or of another type, since a
// page with a dash in it says more than no page, and small pieces of markup.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

inline constexpr const char* kDash = "\u2013";
inline constexpr std::array kShadings = {"diffuse", "specular"};

// Reading the report

/// Null for what is no object or lacks the key.
const Json& member(const Json& object, const char* key);
/// An empty array stands for what is no array.
const Json& list(const Json& object, const char* key);
/// A string as it is, null as nothing, all else as its JSON.
std::string words(const Json& value);
/// NaN for what is no finite number: JSON writes NaN and infinities as null, and a report in memory shows as the one in the file does.
double number(const Json& value);
/// 0 for what is no number, or a negative one.
std::uint64_t count(const Json& value);
/// Whether a report or an asset says so.
bool passed(const Json& object);

/// Null for an asset without stages.
const Json& lastStage(const Json& asset);
/// Of rel_rms; NaN where there is none.
double limitOf(const Json& asset);
/// "256 × 256", "128 × 128 × 6"; empty for what has no texels.
std::string sizeWords(const Json& asset);

// Pieces

Html word(const char* plain);
Html withTitle(const std::string& shown, const std::string& exact);
Html bytesMarkup(std::uint64_t bytes);
Html secondsMarkup(const Json& seconds);
Html percentMarkup(double ratio);
/// A member of `figures` in percent; a dash where it is absent.
Html figureMarkup(const Json& figures, const char* name);

Html numberCell(const Html& content, const Attributes& more = {});
Html headCell(const char* name, const char* kind = "", const Attributes& more = {});
/// rel_rms with a thin meter under it that is full at the limit.
Html limitedCell(const Json& figures, double limit);
/// head, body  rows
Html table(const char* kind, const Html& head, const Html& body);

Html card(const char* title, const Html& content);
Html verdictChip(bool isPassed);
/// One term and what it is, in a list of facts.
Html fact(const char* name, const Html& value);
/// A dot in the colour of a kind of assets.
Html swatch(const std::string& kind);
/// Where the page has the section of an asset.
std::string assetAnchor(std::size_t index);

}  // namespace lightcook::pipeline
