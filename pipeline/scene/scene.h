// scene.toml, read and resolved: what there is to cook, in which units, phase, frame and colour space. docs/scene-file.md is its manual.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/color.h"
#include "formats/error.h"
#include "formats/gpu_texture.h"
#include "formats/light_map.h"

namespace lightcook::pipeline {

enum class Target { Bc, Astc, Float };
std::string_view nameOf(Target target);
formats::Result<Target> targetFromName(std::string_view name, const std::string& subject);

/// Names of the light-map layouts, as `light_map_layout` and `--layout` take them.
const std::vector<std::string>& lightMapLayoutNames();
/// The name that stands for whichever layout keeps the error, or the budget, best.
inline constexpr const char* kAutoLayout = "auto";

/// [output], and what the command line lays over it.
struct OutputSettings {
    Target target = Target::Bc;
    double maxError = 0.1;      ///< on rel_rms of diffuse and of specular, of a light map's (or mesh's) last stage
    bool isErrorAsked = false;  ///< somebody named maxError
    /// The same for dominant lights, cubemaps, tables and reflection maps, whose figures are of quantities of their own; never stricter
    /// than maxError.
    double maxConverterError = 0.1;
    std::optional<std::uint64_t> budgetBytes;  ///< of GPU memory for the whole scene
    std::string lightMapLayout;                ///< one of lightMapLayoutNames(), "auto", or empty: see layoutAsked
    formats::Container container = formats::Container::Ktx2;
    bool zstd = false;
    int effort = 5;     ///< of block encoders, 0 .. 9
    double rdo = 0;     ///< share of error for blocks that repeat, 0 .. kLargestRdo; target bc alone
    bool draco = true;  ///< meshes as Draco inside glTF
};

inline constexpr double kLargestRdo = 1;

/// The layout that these settings ask for: the one named; else "auto" where an error or a budget is, and "ratio" where nothing is.
std::string layoutAsked(const OutputSettings& output);

/// How a light map's dominant light is fitted, as `dominant_fit` and `dominant --fit` take it.
inline const std::vector<std::string> kDominantFitNames = {"closed", "refined", "explained", "refined-ambient"};

struct LightMapEntry {
    std::string name;
    std::filesystem::path file;
    formats::LightMapDescription description;
    std::optional<std::filesystem::path> mesh;
    std::string dominantFit = "closed";                ///< one of kDominantFitNames
    std::optional<std::filesystem::path> groundTruth;  ///< traced light at texels of the map (formats::readShadingValues)
};
struct ProbeEntry {
    std::string name;
    std::filesystem::path file;
    std::optional<std::filesystem::path> sh;  ///< JSON that holds the probe's SH; projected from the image without it
};
/// As `encoding` and `format` of a gradient, and the options of `rsrm`, take them.
inline const std::vector<std::string> kGradientEncodings = {"auto", "linear", "srgb"};
inline const std::vector<std::string> kRsrmFormats = {"rgba8", "bc7", "bc4"};
inline constexpr int kMostGradientZones = 4096;

struct GradientEntry {
    std::string name;
    std::filesystem::path file;
    std::vector<double> exponents = {1, 4, 16, 64, 256, 1024, 4096, 16384};
    std::string encoding = "auto";        ///< of a painted gradient: one of kGradientEncodings
    std::optional<glm::dvec3> axis = {};  ///< the file is an environment, averaged around this world direction
    int zones = 256;                      ///< of such an average
    std::string format = "rgba8";         ///< one of kRsrmFormats
    bool dither = false;                  ///< rgba8 alone
};
/// Why a format, or its dithering, cannot be under a target; empty where it can.
std::string whyNotRsrm(const GradientEntry& entry, Target target);
struct Range {
    double low = 0, high = 0;
};
/// Says more than the glTF, or overrides it; the name "*" is every material.
struct MaterialEntry {
    std::string name;
    std::optional<bool> normalMap, specular;
    std::optional<Range> m, f0;
};

/// How specular tables are made; a scene of `cook` has the default ones, which the shared shaders' analytic light agrees with.
struct TableSettings {
    int viewCount = 8;                     ///< the paper's
    std::optional<int> roughnessCount;     ///< over exactly the range of m; else those of the 16 rows 1/16 to 1 that it needs
    std::string lobe = "beckmann";         ///< kLobeNames
    std::string normalization = "energy";  ///< or halo3, four times as much
    std::string viewAxis = "auto", roughnessAxis = "auto";  ///< fit::viewMappings(), fit::roughnessMappings()
};
inline const std::vector<std::string> kLobeNames = {"beckmann", "ggx", "phong", "phong-power"};

struct Scene {
    std::filesystem::path file;       ///< scene.toml as it was named
    std::filesystem::path directory;  ///< paths of the scene are relative to it
    std::string name;
    OutputSettings output;
    formats::ColorSpaces colors;
    std::vector<LightMapEntry> lightMaps;
    std::vector<ProbeEntry> probes;
    std::vector<GradientEntry> gradients;
    std::vector<MaterialEntry> materials;
    TableSettings tables;
};

/// Unknown keys are refused with the nearest known one; every error names file, line and column, found and expected.
formats::Result<Scene> readScene(const std::filesystem::path& file);

/// "2 MiB", "1.5 GB", "4096": bytes.
formats::Result<std::uint64_t> parseByteCount(std::string_view text, const std::string& subject);

}  // namespace lightcook::pipeline
