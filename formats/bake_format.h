// Bake formats: how a baker writes the light of a light map into files. The table in bakes/bake_format.cpp has a row for each.
// To add a format: a reader like bakes/flat.cpp, a row, a test. All formats share bakes/canonical.cpp: coverage, normals, checks,
// conversion to canonical form.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"
#include "formats/light_map_conventions.h"
#include "formats/light_map_places.h"

namespace lightcook::formats {

class BakeImage;   // bakes/bake_image.h
class BakeReader;  // bakes/bake_reader.h
struct ExrInfo;    // image/exr_file.h

/// Conventions that every file of a format follows. An empty member is left to the scene file.
struct BakeConventions {
    std::optional<ShPhase> phase;
    std::optional<ShFrame> frame;
    std::optional<ShQuantity> quantity;
    std::optional<LightUnits> lightUnits;
};

/// A match of a file with a bake format: of its header, its name and the files beside it.
struct BakeMatch {
    enum class Kind {
        None,       ///< nothing in the file says that it belongs to the format
        Partial,    ///< some of its channels or files are there, others are not: `evidence` says which
        OnlyNamed,  ///< the file can be read so, but nothing says that it is meant so
        Possible,   ///< the shape of the image says so, but other pictures may have that shape too
        Certain     ///< names of channels or files say so
    };
    Kind kind = Kind::None;
    int numberCount = 0;  ///< numbers of a texel that the file has for the format. Of two matches a Certain one is meant, else the larger
    /// "channels sh00.R .. sh08.B"; of Partial, "found 26 of the 27 channels ..., sh05.G is missing". Of None: why the file is not of the
    /// format if that is named; empty if there is nothing to say but that.
    std::string evidence;
    int missingCount = 0;  ///< of Partial: channels or files that are missing
};

/// The surfaces that a bake lies on.
struct BakeSurface {
    std::filesystem::path mesh;
    BakeAxes axes;  ///< of the directions of the file: readers give light and normals in these, and not in those of the mesh
    std::vector<NodePlace> places = {};  ///< LightMapDescription::places
};

struct BakeFormatInfo {
    std::string_view name;     ///< value of the scene key `bake`
    std::string_view caption;  ///< one line for help texts and documents
    std::string_view content;  ///< the channels or files in short, for error messages: "sh00.R .. sh08.B"
    std::string_view assumes;  ///< what no file says and the reader takes for granted, in one clause; empty: nothing
    BakeConventions implied;
    /// Longest band 1 of light, over sqrt(3) sh00, in the baker's formula: 1 of radiance, in which light from one direction has it.
    double longestDirection = 1;
    bool hasDirections = true;                       ///< false: light comes evenly from everywhere
    bool takesEncoding = false;                      ///< the first file is a colour, which LightEncoding may encode in 8 bits
    bool takesLmbake = false;                        ///< Godot writes it, with an lmbake beside it
    bool takesAxes = true;                           ///< false: its directions are those of the mesh's surfaces, which no axes turn
    std::span<const std::string_view> endings = {};  ///< of the names of its files, where a bake is several files of one name
    BakeMatch (*match)(const std::filesystem::path& file, const ExrInfo& info);
    /// Returns the files beside `file` that belong to a bake of this name, whether they exist or not. Null: there are none.
    std::vector<std::filesystem::path> (*filesBeside)(const std::filesystem::path& file);
    /// Opens an image. Null for a format that lies in a glTF or needs a mesh.
    Result<std::unique_ptr<BakeReader>> (*open)(BakeImage image);
    /// Opens a light map of a glTF. Null for a format of images.
    /// image  value of the scene key `image`
    Result<std::unique_ptr<BakeReader>> (*openGltf)(const std::filesystem::path& file, const std::string& image) = nullptr;
    /// Opens an image whose light depends on the surfaces of a mesh: their tangents or normals. Null for other formats.
    Result<std::unique_ptr<BakeReader>> (*openOnMesh)(BakeImage image, const BakeSurface& surface) = nullptr;

    constexpr bool needsMesh() const { return openOnMesh != nullptr; }
};

/// The format that a file was recognised as, and why.
struct BakeRecognition {
    const BakeFormatInfo* format = nullptr;
    std::string evidence;                         ///< of the match; that of a format that was named ends in "as named"
    bool isCertain = false;                       ///< false: nothing but the format's name, or its shape, tells it from another picture
    std::vector<std::string_view> otherReadings;  ///< formats that the file could be read as if they were named
    /// Sets of which the file is a part that was read alone: "found 1 of the 4 files of ...". None if the format was named, or if names of
    /// channels or files say that what was recognised is complete.
    std::vector<std::string> incompleteSets = {};
};

/// Value of the scene key `bake` that chooses the format by the channels, names and sizes of the files.
inline constexpr std::string_view kAutoBake = "auto";

std::span<const BakeFormatInfo> allBakeFormats();
/// Returns "auto" and the names of all bake formats: the values of the scene key `bake`.
std::vector<std::string> bakeNames();
/// Returns the names of the formats that take an encoding.
std::vector<std::string> encodedBakeNames();
/// Returns the names of the formats that lie in a glTF, for which the scene key `image` is.
std::vector<std::string> gltfBakeNames();
/// Returns the names of the formats that Godot writes with an lmbake.
std::vector<std::string> lmbakeBakeNames();
/// Returns the names of the formats whose light depends on the surfaces of a mesh.
std::vector<std::string> meshBakeNames();
/// Returns the file that a bake of several files is opened by, under a value of the scene key `bake`: the first one of the set of which
/// `file` is another one, if both exist; else `file`.
std::filesystem::path leadingFile(const std::filesystem::path& file, std::string_view bake);
/// Returns why a picture of integers that belongs to a set of files, under a value of the scene key `bake`, cannot be read: it is not the
/// first file, and others are missing; or the set is complete, and nothing says how its colours are encoded. Empty: it belongs to no set,
/// or it is the first file of an incomplete one, which may as well be a picture of its own.
std::string faultOfPictureSet(const std::filesystem::path& file, std::string_view bake);
/// Returns the bake format, sh4 or sh9, of a bake that has an image for each coefficient, or for each colour of a coefficient. Fails for
/// other names and for coefficients that are missing.
/// names    "sh00" for a coefficient, "sh00.R" for one colour of it
/// subject  names the list in errors
Result<const BakeFormatInfo*> bakeFormatOfFiles(std::span<const std::string> names, const Subject& subject);
/// Returns the name of a bake: that of its file without extension and without the ending that the files of its format have.
/// bake  name of the bake format that it was recognised as
std::string nameOfBake(const std::filesystem::path& file, std::string_view bake);
/// Returns the files that are read beside `file` under a value of the scene key `bake`, those that exist, sorted.
std::vector<std::filesystem::path> bakeFilesBeside(const std::filesystem::path& file, std::string_view bake);

}  // namespace lightcook::formats
