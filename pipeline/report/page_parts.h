// Parts of the sections of report.html: small pieces of markup, and access to report.json that tolerates absent members and members of
// another type. An old or damaged report so gives a page with dashes instead of no page.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

inline constexpr const char* kDash = "\u2013";
inline constexpr std::array kShadings = {"diffuse", "specular"};

// Reading the report

/// Returns the member, or null if the value is not an object or lacks the key.
const Json& member(const Json& object, const char* key);
/// Returns the member if it is an array, else an empty array.
const Json& list(const Json& object, const char* key);
/// Returns a string as it is, "" for null, and the JSON text of other values.
std::string words(const Json& value);
/// Returns NaN unless the value is a finite number. JSON writes NaN and infinities as null; a report in memory looks like the file's.
double number(const Json& value);
/// Returns 0 unless the value is a number of at least 0.
std::uint64_t count(const Json& value);
/// Returns true if a report or an asset has "passed": true.
bool passed(const Json& object);

/// Returns the last stage, or null for an asset without stages.
const Json& lastStage(const Json& asset);
/// Returns the kinds of shading that were measured of an asset: those with a visible error, a place or a figure other than 0 in any stage;
/// both if there is none.
std::vector<const char*> shadingsOf(const Json& asset);
/// Returns the limit on rel_rms, or NaN if there is none.
double limitOf(const Json& asset);
/// Returns "256 × 256" or "128 × 128 × 6"; empty for an asset without texels.
std::string sizeWords(const Json& asset);

// Pieces

Html word(const char* plain);
Html withTitle(const std::string& shown, const std::string& exact);
Html bytesMarkup(std::uint64_t bytes);
Html secondsMarkup(const Json& seconds);
Html percentMarkup(double ratio);
/// Returns a member of `figures` in percent, or a dash if it is absent.
Html figureMarkup(const Json& figures, const char* name);
/// Returns a visible error of `figures`, or a dash if it is absent.
Html visibleMarkup(const Json& figures, const char* name);
/// Returns a visible error that is a member of `object`, or a dash if it is absent.
Html visibleNumber(const Json& object, const char* name);

Html numberCell(const Html& content, const Attributes& more = {});
Html headCell(const char* name, const char* kind = "", const Attributes& more = {});
/// Returns rel_rms over a thin bar that is full at the limit.
Html limitedCell(const Json& figures, double limit);
/// Returns a visible error, p99 or bound, over a thin bar that is full at the asset's limit on it; without one the error alone.
Html limitedVisibleCell(const Json& figures, const char* name, const Json& asset);
/// head, body  rows
Html table(const char* kind, const Html& head, const Html& body);

Html card(const char* title, const Html& content);
Html verdictChip(bool isPassed);
/// Returns a term and its value for a list of facts.
Html fact(const char* name, const Html& value);
/// Returns a dot in the colour of a kind of assets.
Html swatch(const std::string& kind);
/// Returns the anchor of an asset's section on the page.
std::string assetAnchor(std::size_t index);

}  // namespace lightcook::pipeline
