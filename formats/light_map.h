// SH light maps as bakers write them, brought to canonical form strip by strip (a strip is some rows of a map): scene-linear working
// colour, incident radiance, world axes, no Condon-Shortley signs. Every value is finite, or the file is refused.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/bake_format.h"
#include "formats/color.h"
#include "formats/error.h"
#include "formats/image.h"
#include "formats/light_map_conventions.h"
#include "formats/light_map_places.h"
#include "lighting/sh.h"

namespace lightcook::formats {

/// Describes the content of a file; its members are the keys of [[light_map]] in scene.toml.
struct LightMapDescription {
    std::string bake = std::string(kAutoBake);  ///< name of a bake format (formats/bake_format.h), or "auto"
    ShPhase phase = ShPhase::None;
    ShFrame frame = ShFrame::World;
    BakeAxes axes = {};  ///< of the coefficients, directions and normals of the file; of a tangent frame, those of its normals
    /// Of the coefficients and normals that LightMapReader returns, against those of the mesh: for shaders of engines in other axes.
    BakeAxes outputAxes = {};
    ShQuantity quantity = ShQuantity::Radiance;
    LightUnits lightUnits = LightUnits::Radiometric;
    LightEncoding encoding = LightEncoding::Auto;  ///< of the file, if it is a picture of 8 or 16 bits; for formats that take it
    std::string image = {};                        ///< name of the image of a glTF that has several light maps; empty: it has one
    CoverageSource coverage = CoverageSource::File;
    /// Mesh that the map lies on. Needed by bake formats whose light depends on it (BakeFormatInfo::needsMesh) and for coverage from the
    /// mesh. A bake without normals takes those of the mesh.
    std::filesystem::path mesh = {};
    /// Godot's file with the rectangle of each node of the mesh (formats/lmbake.h). Empty: TEXCOORD_1 are UVs in the whole map.
    std::filesystem::path lmbake = {};
    bool hasNoLmbake = false;  ///< the scene file says that a bake of Godot needs none: UVs are in the whole map already
    /// Places of the nodes of the mesh that the map lies on. Empty: it lies on all of them. Not beside an lmbake.
    std::vector<NodePlace> places = {};
    ColorSpaces colors;
    /// Names of the images of a bake whose coefficients are images of their own (formats/bakes/coefficient_files.h). Empty: one file has
    /// all.
    std::vector<std::string> parts = {};
    std::map<std::string, std::filesystem::path> partFiles = {};  ///< by these names
    /// A covered texel brighter than this many times its brightest neighbour is a firefly; 0 turns the check off.
    double fireflyLimit = 1000;
    /// Repairs invalid texels and counts them (LightMapRepairs); false refuses the file.
    bool repair = false;
    /// LightMapStrip::tangent is wanted, for layouts in tangent space. Normals are those of the mesh then, also where the file has some.
    bool takesTangents = false;
    /// Takes finite coefficients that no light has, as compression leaves them. Not for bakes: wrong conventions are found by them.
    bool isCompressed = false;
    /// Size of a map whose covered texels all hold the same light: it is cooked and verified as one block of that light. Empty: the map is
    /// taken texel by texel. LightMapReader takes no notice of it.
    std::optional<glm::ivec2> constantOf;
};

/// Returns true for the allowed limits: 0, and numbers from 1 on.
constexpr bool isFireflyLimit(double limit) {
    return limit == 0 || (limit >= 1 && limit <= 1e30);
}

struct LightMapRepairs {
    std::int64_t notFinite = 0;  ///< covered texels set to zero because a coefficient was NaN or infinite
    /// Channels of covered texels set to zero because sh00 was negative. Where sh00 is computed from several numbers: those of which a
    /// negative number was set to zero.
    std::int64_t negativeDc = 0;
    std::int64_t bandsBeyond = 0;  ///< bands of a channel scaled down to the longest that light of its sh00 can have
    std::int64_t fireflies = 0;    ///< covered texels that took the mean of their neighbours

    LightMapRepairs& operator+=(const LightMapRepairs& other);
};

/// Counts of the texels of a strip by coverage and normal. A texel counts as covered if it has both.
struct LightMapCoverage {
    std::int64_t inside = 0;          ///< texels with coverage.Y > 0.5; all texels of a file without coverage.Y
    std::int64_t withoutNormal = 0;   ///< of these, texels whose normal is shorter than 1/2, which do not count as covered
    std::int64_t oddNormals = 0;      ///< of these, texels whose normal is far from unit length
    std::int64_t encodedNormals = 0;  ///< of these, texels whose normal n is no unit vector, but 2 n - 1 is: stored as a colour
    /// Smallest and largest finite coverage.Y; infinity and -infinity if there is none.
    float smallest = std::numeric_limits<float>::infinity(), largest = -std::numeric_limits<float>::infinity();

    LightMapCoverage& operator+=(const LightMapCoverage& other);
};

/// Chart of texels that tell no charts apart, and of texels that no filter on a surface reads. Charts have numbers between them.
inline constexpr std::uint32_t kAnyChart = 0, kNoChart = UINT32_MAX;

/// Returns true if a surface may lie between the centres of four neighbouring texels of these charts: all are of one chart, or of any.
constexpr bool mayHoldSurface(const std::array<std::uint32_t, 4>& charts) {
    std::uint32_t found = kAnyChart;
    for (const std::uint32_t chart : charts) {
        if (chart == kNoChart || (chart != kAnyChart && found != kAnyChart && chart != found)) return false;
        if (chart != kAnyChart) found = chart;
    }
    return true;
}

/// Rows [firstRow, firstRow + sh.height()) of a map, all of its width.
struct LightMapStrip {
    int firstRow = 0;
    Image<lighting::ShRgb> sh;    ///< zero where not covered
    Image<std::uint8_t> covered;  ///< 1 inside charts: coverage.Y > 0.5, and a normal where the file has normals; without coverage.Y all 1
    Image<glm::vec3> normal;      ///< unit, world; (0, 0, 1) where not covered, and where neither file nor mesh has one
    /// Unit tangents of the mesh, perpendicular to `normal`; w is 1 or -1: the bitangent is w cross(normal, tangent), and points to the top
    /// of a picture. Empty unless LightMapDescription::takesTangents.
    Image<glm::vec4> tangent;
    /// Charts whose filters read the texels: where mayHoldSurface() is false, nothing is seen of the map. From chart.Y, or of a mip level.
    /// Empty: surfaces may lie beside every covered texel.
    Image<std::uint32_t> chart;
    LightMapRepairs repairs;              ///< of these rows
    LightMapCoverage coverage;            ///< of these rows
    std::int64_t negativeAfterGamut = 0;  ///< channels of sh00 that the colour conversion made negative
};

/// Returns true if LightMapReader reads the mesh of a description: its coverage or its tangents are asked for, the bake format needs it, or
/// the file has no normals and the mesh is there.
bool readsMesh(const std::filesystem::path& file, const LightMapDescription& description);

/// Opens a map and reads strips of it (tiled or scan-line, half or float) without holding the whole map in memory. Texels outside charts
/// may hold any value.
class LightMapReader {
public:
    /// file  names the map in errors; with description.parts it is the first of their files
    static Result<LightMapReader> open(const std::filesystem::path& file, const LightMapDescription& description);
    /// Returns the bake format of a file, also of one that cannot be opened without a mesh.
    static Result<BakeRecognition> recognize(const std::filesystem::path& file, const LightMapDescription& description);
    LightMapReader(LightMapReader&&) noexcept;
    LightMapReader& operator=(LightMapReader&&) noexcept;
    ~LightMapReader();

    int width() const;
    int height() const;
    bool hasNormals() const;      ///< of the file, or of the mesh
    bool hasMeshNormals() const;  ///< of the mesh: those that LightMapDescription::axes does not turn
    bool hasTangents() const;     ///< strips have tangents of the mesh
    bool hasCoverage() const;     ///< the file says which texels lie inside charts
    bool hasDirections() const;   ///< light may come from some directions more than from others: the format has bands above 0
    int tileHeight() const;       ///< rows that are cheap to read together; 64 for scan-line files
    glm::vec3 luminanceWeights() const;
    const glm::dmat3& bt2020FromWorking() const;  ///< see LinearConversion
    /// Returns the primaries that an OpenEXR file states; of a bake of several files, its first. Empty: none that can be compared.
    const std::optional<StatedPrimaries>& primaries() const;
    std::string_view bake() const;               ///< name of the bake format, also where the description says "auto"
    const BakeRecognition& recognition() const;  ///< how the bake format was found

    /// Reads rows [firstRow, firstRow + rowCount). Safe to call from several threads. Does not look for fireflies: checkFireflies() does,
    /// because it needs the neighbours.
    Result<LightMapStrip> read(int firstRow, int rowCount) const;
    /// Returns a digest of what the files store of rows [firstRow, firstRow + rowCount), without decoding them: under the same description,
    /// mesh and lmbake, rows of equal digests are equal. Empty: nobody knows. Safe to call from several threads.
    Result<std::string> storedDigest(int firstRow, int rowCount) const;
    /// Returns where a colour of a coefficient of texel (x, y) is stored, for errors: "map.exr, channel sh00.R, texel (3, 4)". Of one that
    /// is computed from several numbers, one of them.
    Subject placeOf(std::size_t coefficient, int colour, int x, int y) const;

private:
    struct State;
    explicit LightMapReader(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Channels that a LightMapWriter writes beside the coefficients: none; coverage.Y and normal.X, Y and Z; or these and chart.Y.
enum class SurfaceOutput { None, CoverageAndNormals, CoverageNormalsAndCharts };

/// Coverage, normals and charts of the texels of some rows. The views have one size.
struct SurfaceRows {
    ImageView<const std::uint8_t> covered;
    ImageView<const glm::vec3> normal;
    ImageView<const std::uint32_t> chart = {};  ///< of SurfaceOutput::CoverageNormalsAndCharts: numbers below 2^24, or kNoChart
};

/// Writes bake format sh9 in canonical form, as floats in ZIP tiles of 64 x 64. Rows are appended in order from row 0. The file appears at
/// commit(), complete.
class LightMapWriter {
public:
    static Result<LightMapWriter> create(const std::filesystem::path& file, int width, int height,
                                         SurfaceOutput surface = SurfaceOutput::None);
    LightMapWriter(LightMapWriter&&) noexcept;
    LightMapWriter& operator=(LightMapWriter&&) noexcept;
    ~LightMapWriter();
    Result<void> append(ImageView<const lighting::ShRgb> rows);
    /// Appends rows of a map with another SurfaceOutput than None. The views have one size.
    Result<void> append(ImageView<const lighting::ShRgb> rows, const SurfaceRows& surface);
    Result<void> commit();

private:
    struct State;
    explicit LightMapWriter(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::formats
