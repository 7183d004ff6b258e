#include "pipeline/report/captions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/note_keys.h"

namespace lightcook::pipeline {
namespace {

struct Caption {
    std::string_view name, words;
};

constexpr std::array kStages = {
    Caption{"total", "whole asset"},
    Caption{"repacked", "whole asset, against the repacked bake"},
    Caption{"half", "16-bit floats"},
    Caption{"exit", "exit radiance"},
    Caption{"stage 1", "first texture"},
    Caption{"stage 2", "second texture, of what the first one left"},
    Caption{"l0", "mean light"},
    Caption{"l1", "linear band"},
    Caption{"rnm", "light of three directions"},
    Caption{"ratio", "directions, as ratios to the mean"},
    Caption{"zonal", "zonal part of band 2"},
    Caption{"code", "directions, by learned bases"},
    Caption{"residual 1", "first refinement"},
    Caption{"residual 2", "second refinement"},
    Caption{"residual 3", "third refinement"},
    Caption{"residual 4", "fourth refinement"},
    Caption{"residual 5", "fifth refinement"},
    Caption{"magnified", "filtering between texels, at samples"},
    Caption{"divide", "division and encoding, at all texels"},
    Caption{"filter", "filtering between stored entries, at samples"},
    Caption{"quantize", "quantization of stored entries"},
};

constexpr std::array kNotes = {
    Caption{note_keys::kCoveredTexels, "Texels inside charts"},
    Caption{note_keys::kPacking, "Charts packed anew"},
    Caption{note_keys::kSplit, "Charts split between maps"},
    Caption{note_keys::kUnreadTexels, "Texels inside charts that no triangle reads: left out of the packed map"},
    Caption{note_keys::kUnreadLevels, "Largest levels that no material is smooth enough to read"},
    Caption{note_keys::kUnreadBytes, "Memory of these levels [bytes]"},
    Caption{note_keys::kWholeVisible, "Visible error of the whole shading (p99), as the trial measured it"},
    Caption{note_keys::kBeyondPositiveBounds, "Texels whose coefficients no positive light could give"},
    Caption{note_keys::kRepairedNotFinite, "Texels set to zero because a coefficient was not finite"},
    Caption{note_keys::kRepairedNegativeDc, "Channels set to zero because their mean was negative"},
    Caption{note_keys::kRepairedBands, "Bands scaled down to what light of their mean can have"},
    Caption{note_keys::kRepairedFireflies, "Stray bright texels that took the mean of their neighbours"},
    Caption{note_keys::kRepairedTexels, "Texels repaired because they were negative or not finite"},
    Caption{note_keys::kNegativeAfterGamut, "Values negative in the working colour space"},
    Caption{note_keys::kClampedHigh, "Values clamped to the format's largest"},
    Caption{note_keys::kClampedLight, "Values of light above 65504, which became 65504"},
    Caption{note_keys::kClampedNegative, "Negative values clamped to zero, all an unsigned format holds"},
    Caption{note_keys::kDivisionClamped, "Values whose division passed the largest float,"},
    Caption{note_keys::kDivisionLost, "Values lost under the texture's smallest step,"},
    Caption{note_keys::kFormatsTried, "Errors of the format"},
    Caption{note_keys::kWindowLambda, "Strength of the window against ringing (lambda)"},
    Caption{note_keys::kFit, "Method of the fit"},
    Caption{note_keys::kRefined, "Texels whose direction was searched"},
    Caption{note_keys::kSkipped, "Texels that kept the closed form: black, without a direction, or within the tolerance"},
    Caption{note_keys::kSolvedWithNeighbours, "Texels fitted together with their neighbours"},
    Caption{note_keys::kLightMapUvBits, "Bits of a light-map UV"},
    Caption{note_keys::kNormalBits, "Bits of a normal"},
    Caption{note_keys::kBoundOfRelRms, "Upper bound of the error that these bits make (rel_rms)"},
    Caption{note_keys::kZones, "Zones of equal solid angle that the source was read in"},
    Caption{note_keys::kAsymmetricEnergy, "Share of the source's energy that is not symmetric around its axis"},
    Caption{note_keys::kGradientUncertainty, "Uncertainty of the average around the axis, of the largest value"},
    Caption{note_keys::kCodeError, "Largest error at a texel centre [codes]"},
    Caption{note_keys::kStepCodes, "Largest step between neighbours beyond the exact one [codes]"},
    Caption{note_keys::kStepContrast, "The same, relative to the light there"},
    Caption{note_keys::kBandCodes, "Largest mean error of 8 neighbours, which shows as a band [codes]"},
    Caption{note_keys::kDirectionErrorDegreesMean, "Mean error of a light's direction [degrees]"},
    Caption{note_keys::kDirectionErrorDegreesMax, "Largest error of a light's direction [degrees]"},
    Caption{note_keys::kUnexplainedEnergyStored, "Share of the light that one direction does not explain, as stored"},
    Caption{note_keys::kUnexplainedEnergyReference, "Share of the light that one direction does not explain, in the bake"},
    Caption{note_keys::kShadedEveryTexels, "Distance of the samples between texels; texels are shaded all"},
};

const Caption* find(std::span<const Caption> table, std::string_view name) {
    const auto found = std::ranges::find(table, name, &Caption::name);
    return found == table.end() ? nullptr : &*found;
}

std::string wordsOf(std::span<const Caption> table, std::string_view name) {
    const Caption* const row = find(table, name);
    return std::string(row != nullptr ? row->words : name);
}

}  // namespace

std::string stageCaption(std::string_view name) {
    return wordsOf(kStages, name);
}

bool hasStageCaption(std::string_view name) {
    return find(kStages, name) != nullptr;
}

std::string kindCaption(std::string_view kind) {
    const auto known = assetKindFromName(kind);
    return std::string(known ? info(*known).shortCaption : kind);
}

std::string noteCaption(std::string_view key) {
    std::string caption = wordsOf(kNotes, key);
    if (caption == key) std::ranges::replace(caption, '_', ' ');
    return caption;
}

bool hasNoteCaption(std::string_view key) {
    return find(kNotes, key) != nullptr;
}

std::string counted(std::uint64_t count, std::string_view what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

}  // namespace lightcook::pipeline
