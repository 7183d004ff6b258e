// Settings of a scene, resolved: defaults that depend on other settings, settings of the output that an asset overrides, and settings that
// cannot be combined.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "formats/layout_cost.h"
#include "lighting/display.h"
#include "pipeline/limits/limits.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

inline constexpr double kDefaultMaxError = 0.1;  ///< of meshes, and of converterLimits
inline constexpr double kDefaultMaxVisible = 5;  ///< of layout "auto" where nothing else is asked for

/// Returns max_error, or its default.
double errorLimit(const OutputSettings& output);

/// Returns true if the layout of a light map is open and nothing says how good it has to be: the default limit on visible errors then
/// chooses it. It is a wish, not a demand: where no layout keeps it, the best one passes.
bool isByDefault(const OutputSettings& output, const LightMapEntry& entry);

/// Returns the limit on the 99th percentile of visible errors that was asked for: that of the light map or else that of the output.
std::optional<double> askedVisibleLimit(const OutputSettings& output, const LightMapEntry& entry);

/// Returns the limit on the 99th percentile of visible errors: that of the light map or else that of the output; without either, the
/// default where it chooses the layout (isByDefault). Empty: no limit.
std::optional<double> visibleLimit(const OutputSettings& output, const LightMapEntry& entry);

/// Returns true if a limit on the errors of a light map is given: its own or that of the output.
bool isErrorLimited(const OutputSettings& output, const LightMapEntry& entry);

/// Default limit of cubemaps. A block holds a small light source and the dark beside it within 0.34, and noise within 0.18
/// (docs/lab/verify.md): that is what its format can do, and no fault.
inline constexpr double kDefaultMaxCubemapError = 0.5;

/// Returns the limits of a dominant light, cubemap, table or reflection map: maxConverterError or else the larger of maxError and the
/// default; and its own limits on visible errors or else those of the output.
/// byDefault  kDefaultMaxError, or kDefaultMaxCubemapError
Limits converterLimits(const OutputSettings& output, double byDefault, const Limits& ofAsset = {});

/// Returns the limits that a light map is held to: its own, or else those of the output. The default on visible errors is one of them where
/// it chooses the layout; that of the output on seams counts only with a mesh.
Limits limitsOf(const OutputSettings& output, const LightMapEntry& entry);

/// Returns the limits that the layout of a light map is chosen by: those that it is held to, and kNoErrorLimit.
Limits layoutLimits(const OutputSettings& output, const LightMapEntry& entry);

/// Returns the limits on what a pixel shows of a light map and its dominant light together.
Limits wholeLimits(const OutputSettings& output);

/// Returns the layout that the settings select: the named one, or else "auto".
std::string layoutAsked(const OutputSettings& output);

/// Returns the layouts that "auto" may take for a light map: its own list, or else that of the output.
const formats::LayoutList& layoutsFor(const OutputSettings& output, const LightMapEntry& entry);

/// Returns true if a light map may get a layout in tangent space.
bool takesTangents(const OutputSettings& output, const LightMapEntry& entry);

/// Returns true if a light map gets mip levels.
bool hasMips(const OutputSettings& output, const LightMapEntry& entry);
/// Returns true if the charts of a light map are packed anew.
bool isPacked(const OutputSettings& output, const LightMapEntry& entry);
/// Returns the visible error that fewer texels of its charts may add.
double chartsMaxVisible(const OutputSettings& output, const LightMapEntry& entry);

/// Returns true if a budget chooses the views of the tables: kLeastViewCount or kFineViewCount.
bool areViewsOpen(const TableSettings& tables, const OutputSettings& output);
/// Returns the views of the tables where no budget chooses them: their own or, without, kFineViewCount.
int viewCountOf(const TableSettings& tables);

/// Returns the folder that a scene is cooked to: the one that was given, or without one (empty) that of its name; of a scene that is one of
/// several targets, the folder of the target in there.
std::filesystem::path cookedFolder(const Scene& scene, const std::filesystem::path& given);

/// Return the rules between the settings of a table, and whether they are broken. Those of a whole scene are of its root.
std::vector<SettingsRule> rulesOf(const OutputSettings& output);
std::vector<SettingsRule> rulesOf(const formats::ColorSpaces& colors);
std::vector<SettingsRule> rulesOf(const Scene& scene, const LightMapEntry& entry);
std::vector<SettingsRule> rulesOf(const OutputSettings& output, const GradientEntry& gradient);
std::vector<SettingsRule> rulesOf(const Scene& scene);

/// Returns what is wrong with a scene without anything to cook, or an empty text.
std::string whyNothing(const Scene& scene);

}  // namespace lightcook::pipeline
