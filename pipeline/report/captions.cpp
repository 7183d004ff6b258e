#include "pipeline/report/captions.h"

#include <algorithm>
#include <array>
#include <span>

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
    Caption{"ratio", "directions, as ratios to the mean"},
    Caption{"zonal", "zonal part of band 2"},
    Caption{"code", "directions, by learned bases"},
    Caption{"residual 1", "first refinement"},
    Caption{"residual 2", "second refinement"},
    Caption{"residual 3", "third refinement"},
    Caption{"residual 4", "fourth refinement"},
    Caption{"residual 5", "fifth refinement"},
    Caption{"magnified", "filtering between texels"},
    Caption{"divide", "division and encoding, at texels"},
    Caption{"filter", "filtering between stored entries"},
    Caption{"quantize", "quantization of stored entries"},
};

constexpr std::array kKinds = {
    Caption{"light-map", "light map"}, Caption{"dominant", "dominant light"}, Caption{"cubemap", "cubemap"},
    Caption{"lut", "specular tables"}, Caption{"rsrm", "reflection map"},     Caption{"mesh", "mesh"},
};

constexpr std::array kNotes = {
    Caption{"covered_texels", "Texels inside charts"},
    Caption{"packing", "Charts packed anew"},
    Caption{"split", "Charts split between two maps"},
    Caption{"unread_texels", "Texels inside charts that no triangle reads: left out of the packed map"},
    Caption{"unread_levels", "Largest levels that no material is smooth enough to read"},
    Caption{"unread_bytes", "Memory of these levels [bytes]"},
    Caption{"whole_visible", "Visible error of the whole shading (p99), as the trial measured it"},
    Caption{"beyond_positive_bounds", "Texels whose coefficients no positive light could give"},
    Caption{"repaired_not_finite", "Texels set to zero because a coefficient was not finite"},
    Caption{"repaired_negative_dc", "Channels set to zero because their mean was negative"},
    Caption{"repaired_bands", "Bands scaled down to what light of their mean can have"},
    Caption{"repaired_fireflies", "Stray bright texels that took the mean of their neighbours"},
    Caption{"repaired_texels", "Texels repaired because they were negative or not finite"},
    Caption{"negative_after_gamut", "Values negative in the working colour space"},
    Caption{"clamped_high", "Values clamped to the format's largest"},
    Caption{"clamped_light", "Values of light above 65504, which became 65504"},
    Caption{"clamped_negative", "Negative values clamped to zero, all an unsigned format holds"},
    Caption{"division_clamped", "Values whose division passed the largest float,"},
    Caption{"division_lost", "Values lost under the texture's smallest step,"},
    Caption{"formats_tried", "Errors of the format"},
    Caption{"window_lambda", "Strength of the window against ringing (lambda)"},
    Caption{"fit", "Method of the fit"},
    Caption{"refined", "Texels whose direction was searched"},
    Caption{"skipped", "Texels that kept the closed form: black, without a direction, or within the tolerance"},
    Caption{"solved_with_neighbours", "Texels fitted together with their neighbours"},
    Caption{"light_map_uv_bits", "Bits of a light-map UV"},
    Caption{"normal_bits", "Bits of a normal"},
    Caption{"bound_of_rel_rms", "Upper bound of the error that these bits make (rel_rms)"},
    Caption{"zones", "Zones of equal solid angle that the source was read in"},
    Caption{"asymmetric_energy", "Share of the source's energy that is not symmetric around its axis"},
    Caption{"gradient_uncertainty", "Uncertainty of the average around the axis, of the largest value"},
    Caption{"code_error", "Largest error at a texel centre [codes]"},
    Caption{"step_codes", "Largest step between neighbours beyond the exact one [codes]"},
    Caption{"step_contrast", "The same, relative to the light there"},
    Caption{"band_codes", "Largest mean error of 8 neighbours, which shows as a band [codes]"},
    Caption{"direction_error_degrees_mean", "Mean error of a light's direction [degrees]"},
    Caption{"direction_error_degrees_max", "Largest error of a light's direction [degrees]"},
    Caption{"unexplained_energy_stored", "Share of the light that one direction does not explain, as stored"},
    Caption{"unexplained_energy_reference", "Share of the light that one direction does not explain, in the bake"},
    Caption{"shaded_every_texels", "Distance of the texels that were shaded for these figures"},
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
    return wordsOf(kKinds, kind);
}

std::string noteCaption(std::string_view key) {
    std::string caption = wordsOf(kNotes, key);
    if (caption == key) std::ranges::replace(caption, '_', ' ');
    return caption;
}

bool hasNoteCaption(std::string_view key) {
    return find(kNotes, key) != nullptr;
}

}  // namespace lightcook::pipeline
