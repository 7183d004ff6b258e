// scene.toml as it is read: the assets to cook, with units, sign convention, frame and colour space. docs/reference/scene-file.md lists its
// keys; settings.h resolves what a scene leaves open.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/color.h"
#include "formats/error.h"
#include "formats/gpu_texture.h"
#include "formats/layout_cost.h"
#include "formats/light_map.h"
#include "formats/light_map_objective.h"
#include "formats/probe_place.h"
#include "formats/specular_lobe.h"
#include "formats/target.h"
#include "lighting/display.h"
#include "pipeline/document/keys.h"
#include "pipeline/scene/chart_settings.h"
#include "pipeline/scene/lint_checks.h"
#include "pipeline/scene/scene_lines.h"
#include "pipeline/scene/up_axis.h"

namespace lightcook::pipeline {

using formats::Target;

/// Returns the names of the light-map layouts, as `light_map_layout` and `--layout` take them, without "auto".
const std::vector<std::string>& lightMapLayoutNames();
/// Returns the same names and "auto".
const std::vector<std::string>& lightMapLayoutChoices();
/// Selects the smallest layout that meets the error, or the one of least error within the budget.
inline constexpr const char* kAutoLayout = "auto";

/// The section [output], with the overrides of the command line.
struct OutputSettings {
    Target target = Target::Bc;
    formats::Container container = formats::Container::Ktx2;
    std::string lightMapLayout;  ///< one of lightMapLayoutNames(), "auto", or empty: see layoutAsked
    /// Limit on rel_rms of diffuse and of specular, of the last stage of a light map or mesh; see errorLimit.
    std::optional<double> maxError;
    /// Limit of dominant lights, cubemaps, tables and reflection maps, each on its own quantity; see converterLimits.
    std::optional<double> maxConverterError;
    std::optional<double> maxVisible;       ///< limit on the 99th percentile of visible errors of light maps; see visibleLimit
    std::optional<double> maxVisibleBound;  ///< limit on the proven bound of visible errors
    std::optional<double> maxSeam;          ///< limit on the largest step that cooking adds to an edge of light maps
    /// Limit on the 99th percentile of visible errors of what a pixel shows: light map and dominant light together.
    std::optional<double> maxWholeVisible;
    std::optional<double> maxWholeError;  ///< limit on rel_rms of the same
    /// Limit on the 99th percentile of visible errors of dominant lights, cubemaps, tables and reflection maps; see converterLimits.
    std::optional<double> maxConverterVisible;
    std::optional<double> maxConverterVisibleBound;  ///< the same on their proven bound
    /// Returns true if a limit on the error of light maps is given.
    bool isErrorLimited() const { return maxError || maxVisible || maxVisibleBound || maxSeam; }
    std::optional<std::uint64_t> budgetBytes;  ///< of GPU memory for the whole scene
    /// Returns true if light maps and their dominant lights are chosen together, by what a pixel shows.
    bool isChosenByWhole() const { return budgetBytes || isWholeLimited(); }
    bool isWholeLimited() const { return maxWholeVisible || maxWholeError; }
    double rdo = 0;  ///< share by which the error may grow so that blocks repeat, 0 .. kLargestRdo; target bc only
    formats::Objective objective = formats::Objective::Visible;  ///< of learned layouts of light maps
    formats::LayoutCost cost = formats::LayoutCost::Bytes;       ///< of layouts, where "auto" chooses one within an error
    formats::DecodeLimits decode = {};                           ///< of layouts
    formats::LayoutList layouts = {};                            ///< that "auto" may take
    int effort = 5;                                              ///< of block encoders, 0 .. 9
    bool keepUnused = false;                                     ///< cooks also what no material, surface or shading shows
    bool zstd = false;
    bool draco = true;  ///< meshes as Draco inside glTF
    bool gltf = false;  ///< also writes the scene as glTF with its light maps bound
    bool mips = false;  ///< light maps have as many mip levels as keep their charts apart; dominant lights have one
    ChartSettings charts = {};
};

inline constexpr double kLargestRdo = 1;

struct LightMapEntry {
    std::string name;
    std::filesystem::path file;
    formats::LightMapDescription description;
    std::optional<std::filesystem::path> mesh;
    std::string dominantFit = "explained";           ///< a name of allDominantFits()
    std::optional<std::string> dominantLayout = {};  ///< a name of allDominantLayouts(); absent: the first or, with a budget, what it buys
    std::optional<double> maxVisible;                ///< overrides that of the output
    std::optional<double> maxVisibleBound;           ///< overrides that of the output
    std::optional<double> maxSeam;                   ///< overrides that of the output
    std::optional<std::filesystem::path> groundTruth;  ///< traced light at texels of the map (formats::readShadingValues)
    formats::LayoutList layouts = {};                  ///< that "auto" may take; empty: those of the output
    std::optional<bool> mips = {};                     ///< overrides that of the output
    ChartSettings charts = {};                         ///< override those of the output
    std::optional<ChartPart> part = {};                ///< set by a cook that splits the charts: those that this map has
    std::optional<double> white = {};  ///< set with `part`: exit radiance that a display shows as diffuse white, by the key of all charts

    /// Returns the name that the light map has in the scene file.
    const std::string& nameInScene() const { return part ? part->of : name; }
};

struct ProbeEntry {
    std::string name;
    std::filesystem::path file;
    std::optional<std::filesystem::path> sh;     ///< JSON that holds the probe's SH; projected from the image without it
    int size = 128;                              ///< of a face [texels]: a power of two, kLeastProbeSize .. kMostProbeSize
    bool readLevelsOnly = true;                  ///< leave out the large levels that no material reads
    std::string layout = "pre-divided";          ///< a name of allCubemapLayouts()
    formats::ProbePlace place = {};              ///< goes before that of the file `sh`
    std::optional<double> maxVisible = {};       ///< overrides maxConverterVisible of the output
    std::optional<double> maxVisibleBound = {};  ///< overrides that of the output
};
/// Values of `encoding` of a gradient, and of `rsrm --encoding`.
inline const std::vector<std::string> kGradientEncodings = {"auto", "linear", "srgb"};
inline constexpr int kMostGradientZones = 4096;

/// Value of `size` of a probe that leaves out the levels that no material reads.
inline constexpr std::string_view kAutoProbeSize = "auto";

struct GradientEntry {
    std::string name;
    std::filesystem::path file;
    std::vector<double> exponents = {1, 4, 16, 64, 256, 1024, 4096, 16384};
    std::string encoding = "auto";               ///< one of kGradientEncodings; for painted gradients only
    std::optional<glm::dvec3> axis = {};         ///< the file is an environment, averaged around this world direction
    int zones = 256;                             ///< of the average around the axis
    std::string format = {};                     ///< one of rsrmFormatChoices(); empty: see rsrmFormatsToTry
    bool dither = false;                         ///< rgba8 alone
    std::optional<double> maxVisible = {};       ///< overrides maxConverterVisible of the output
    std::optional<double> maxVisibleBound = {};  ///< overrides that of the output
};
/// Adds to a material of the glTF, or overrides it; the name "*" is every material.
struct MaterialEntry {
    std::string name;
    std::optional<bool> normalMap, specular;
    std::optional<Range> m, f0;
    std::optional<double> normalMapTilt = {};  ///< largest angle of a normal map's normal from the surface's [degrees]
};

/// Settings of the specular tables. The analytic light of the shaders agrees with the default normalization.
struct TableSettings {
    std::optional<int> viewCount;          ///< absent: see areViewsOpen and viewCountOf
    std::optional<int> roughnessCount;     ///< over exactly the range of m; else those of the 16 rows 1/16 to 1 that it needs
    std::string normalization = "energy";  ///< or halo3, four times as bright
    std::string viewAxis = "auto", roughnessAxis = "auto";  ///< fit::viewMappings(), fit::roughnessMappings()
    std::optional<double> maxVisible = {};                  ///< overrides maxConverterVisible of the output
    std::optional<double> maxVisibleBound = {};             ///< overrides that of the output
};
inline const std::vector<std::string> kNormalizationNames = {"energy", "halo3"};
inline constexpr int kMostTableNodes = 1024;  ///< columns, or rows

/// Views of the tables. With 24, 3 KiB more than the 8 of Chen and Liu 2008, they cause less than 2 % of the squared error of the whole
/// shading in place of 25 to 42 %.
inline constexpr int kFineViewCount = 24;
inline constexpr int kLeastViewCount = 8;  ///< under a budget whose layouts leave no room for more
/// Return "auto" and the names of fit::viewMappings() or fit::roughnessMappings().
std::vector<std::string> viewAxisNames();
std::vector<std::string> roughnessAxisNames();

struct Scene {
    std::filesystem::path file;       ///< path of scene.toml as given
    std::filesystem::path directory;  ///< paths of the scene are relative to it
    std::string name;
    OutputSettings output;
    formats::ColorSpaces colors;
    lighting::DisplaySettings display;
    std::vector<LightMapEntry> lightMaps;
    std::vector<ProbeEntry> probes;
    std::vector<GradientEntry> gradients;
    std::vector<MaterialEntry> materials;
    TableSettings tables;
    SceneLines lines;  ///< of the scene file
    /// Specular lobe of cubemaps, tables, dominant lights, shader and verification. In a scene file one of formats::sceneLobes(); `lut` has
    /// all.
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;
    std::vector<Allowance> allowances;  ///< key `allow`
    UpAxis up = UpAxis::Y;              ///< of world space: the axis of painted gradients
};

/// Reads a scene file. Unknown keys are refused with the nearest known one. Errors name file, line and column, found and expected.
formats::Result<Scene> readScene(const std::filesystem::path& file);

/// Returns the place of a table or key in the scene file, "scene.toml:7"; without a scene file `otherwise`.
std::string placeIn(const Scene& scene, std::string_view section, std::string_view name, std::string_view key,
                    const std::string& otherwise);

}  // namespace lightcook::pipeline
