// Keys of `notes` and `measures` in a report. Cook and verify actions write them; viewer/report/captions.js has their words.
#pragma once

namespace lightcook::pipeline::note_keys {

// Light maps
inline constexpr const char* kCoveredTexels = "covered_texels";
inline constexpr const char* kBeyondPositiveBounds = "beyond_positive_bounds";
inline constexpr const char* kRepairedNotFinite = "repaired_not_finite";
inline constexpr const char* kRepairedNegativeDc = "repaired_negative_dc";
inline constexpr const char* kRepairedBands = "repaired_bands";
inline constexpr const char* kRepairedFireflies = "repaired_fireflies";
inline constexpr const char* kNegativeAfterGamut = "negative_after_gamut";
inline constexpr const char* kClampedLight = "clamped_light";
inline constexpr const char* kPacking = "packing";
inline constexpr const char* kUnreadTexels = "unread_texels";
inline constexpr const char* kWholeVisible = "whole_visible";

// Encoders
inline constexpr const char* kClampedHigh = "clamped_high";
inline constexpr const char* kClampedNegative = "clamped_negative";

// Dominant lights
inline constexpr const char* kFit = "fit";
inline constexpr const char* kRefined = "refined";
inline constexpr const char* kSkipped = "skipped";
inline constexpr const char* kSolvedWithNeighbours = "solved_with_neighbours";
inline constexpr const char* kDirectionErrorDegreesMean = "direction_error_degrees_mean";
inline constexpr const char* kDirectionErrorDegreesMax = "direction_error_degrees_max";
inline constexpr const char* kUnexplainedEnergyStored = "unexplained_energy_stored";
inline constexpr const char* kUnexplainedEnergyReference = "unexplained_energy_reference";
inline constexpr const char* kShadedEveryTexels = "shaded_every_texels";

// Cubemaps and reflection maps
inline constexpr const char* kRepairedTexels = "repaired_texels";
inline constexpr const char* kUnreadLevels = "unread_levels";
inline constexpr const char* kUnreadBytes = "unread_bytes";
inline constexpr const char* kWindowLambda = "window_lambda";
inline constexpr const char* kDivisionClamped = "division_clamped";
inline constexpr const char* kDivisionLost = "division_lost";
inline constexpr const char* kFormatsTried = "formats_tried";
inline constexpr const char* kZones = "zones";
inline constexpr const char* kAsymmetricEnergy = "asymmetric_energy";
inline constexpr const char* kGradientUncertainty = "gradient_uncertainty";
inline constexpr const char* kCodeError = "code_error";
inline constexpr const char* kStepCodes = "step_codes";
inline constexpr const char* kStepContrast = "step_contrast";
inline constexpr const char* kBandCodes = "band_codes";

// Meshes
inline constexpr const char* kLightMapUvBits = "light_map_uv_bits";
inline constexpr const char* kNormalBits = "normal_bits";
inline constexpr const char* kBoundOfRelRms = "bound_of_rel_rms";

}  // namespace lightcook::pipeline::note_keys
