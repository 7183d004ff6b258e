// Interface between the readers of the bake formats and the conversion to canonical form that they share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/bake_format.h"
#include "formats/bakes/bake_image.h"
#include "formats/image.h"
#include "formats/image/exr_file.h"
#include "formats/light_map.h"
#include "lighting/sh.h"

namespace lightcook::formats {

/// Rows that are read together from a file that is not tiled, and the tile extent of the maps that we write.
inline constexpr int kTileExtent = 64;

/// The texels of a strip as the file stores them: its own sign convention, frame, quantity, units and colour space.
struct RawStrip {
    Image<lighting::ShRgb> sh;
    Image<float> coverage;     ///< above 0.5 inside charts; empty if the file does not say
    Image<glm::vec3> normal;   ///< world space, any length; empty if the file has none
    Image<glm::vec4> tangent;  ///< of the mesh: see LightMapStrip::tangent; empty unless it is wanted
    Image<float> chart;        ///< number of the chart whose filter reads the texel, 0: none does; empty if the file does not say
    /// Bits 0, 1 and 2: a number that is light of R, G or B is negative, and `sh` was computed as if it was 0. Empty: there is none. For
    /// formats whose first coefficient is computed from several numbers.
    Image<std::uint8_t> negative = {};
};

/// A place in the files of a bake: it holds one number.
struct StoredNumber {
    Subject file;
    std::string channel;
    int x = 0, y = 0;
    std::optional<float> value = {};  ///< empty: it is the coefficient
};

/// Reads the texels of one bake. One class a bake format.
class BakeReader {
public:
    virtual ~BakeReader() = default;
    virtual int width() const = 0;
    virtual int height() const = 0;
    /// Returns the number of rows that are cheap to read together.
    virtual int tileHeight() const = 0;
    /// Returns the number of slices that a bake of Godot has one above the other; nothing if its files do not say.
    virtual std::optional<int> sliceCount() const { return std::nullopt; }
    virtual bool hasNormals() const = 0;
    virtual bool hasCoverage() const = 0;
    /// Returns the channel of coverage, for errors. Empty: no channel has it.
    virtual std::string coverageChannel() const { return ""; }
    /// Reads rows [firstRow, firstRow + rowCount). Safe to call from several threads.
    virtual Result<RawStrip> read(int firstRow, int rowCount) const = 0;
    /// Returns a digest of what the files store of rows [firstRow, firstRow + rowCount): with the same description and mesh, rows of equal
    /// digests are equal. Empty: nobody knows. Safe to call from several threads.
    virtual Result<std::string> storedDigest([[maybe_unused]] int firstRow, [[maybe_unused]] int rowCount) const { return std::string(); }
    /// Returns where a colour of a coefficient of texel (x, y), which is no light, is stored. Of one that is computed from several numbers:
    /// the number at fault. Empty: the file has no such place.
    virtual std::optional<StoredNumber> placeOf([[maybe_unused]] std::size_t coefficient, [[maybe_unused]] int colour,
                                                [[maybe_unused]] int x, [[maybe_unused]] int y) const {
        return std::nullopt;
    }
};

/// Finds the row of the format that `bake` names or, for "auto", the format with the most numbers a texel among those that fit the file.
/// Fails if the file lacks a part of that format, if no format fits (the error lists the file's channels and the known formats), or if two
/// formats fit and nothing says which is meant.
/// file  names it in errors, and may have a part in the recognition; it need not exist
Result<BakeRecognition> findBakeFormat(const std::string& bake, const std::filesystem::path& file, const ExrInfo& info);
/// Returns true if `file` may be of a format that needs a mesh, under a value of the scene key `bake`.
bool mayNeedMesh(const std::filesystem::path& file, std::string_view bake);
/// Fails if `bake` is neither "auto" nor the name of a bake format.
Result<void> checkBakeName(const std::string& bake, const Subject& subject);
/// Fails if the file is encoded but the format takes no encoding.
Result<void> checkEncoding(LightEncoding encoding, const BakeFormatInfo& format, const Subject& subject);
/// Fails if an image of a glTF is named but the format lies in none.
Result<void> checkImage(const std::string& image, const BakeFormatInfo& format, const Subject& subject);
/// Fails if axes are given but the format has none of its own.
Result<void> checkAxes(const BakeAxes& axes, const BakeFormatInfo& format, const Subject& subject);
/// Fails if an lmbake is given but Godot does not write the format.
Result<void> checkLmbake(const std::filesystem::path& lmbake, const BakeFormatInfo& format, const Subject& subject);

/// Returns the description with the conventions that the format implies. Fails if the description has another one that is not the default:
/// then the scene file contradicts the format.
Result<LightMapDescription> withImplied(LightMapDescription description, const BakeFormatInfo& format, const Subject& subject);

}  // namespace lightcook::formats
