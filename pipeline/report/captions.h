// Plain words for the names that report.json has: stages, kinds, shadings, notes. Words for counts.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lightcook::pipeline {

/// Returns the caption of a stage: "filtering between texels" for "magnified". A name without a row is returned as it is.
std::string stageCaption(std::string_view name);
bool hasStageCaption(std::string_view name);

/// Returns "light map" for "light-map". A name without a row is returned as it is.
std::string kindCaption(std::string_view kind);

/// Returns the caption of a note or measure. A key without a row is returned with spaces for underscores.
std::string noteCaption(std::string_view key);
bool hasNoteCaption(std::string_view key);

/// Returns "1 asset" or "2 assets".
/// what  one of them
std::string counted(std::uint64_t count, std::string_view what);

}  // namespace lightcook::pipeline
