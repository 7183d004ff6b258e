// An image of a bake: an EXR file that is read row by row, or a picture that is held in memory.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/image.h"
#include "formats/image/exr_file.h"
#include "formats/light_map_conventions.h"

namespace lightcook::formats {

class BakeImage {
public:
    /// Opens the image of colours of a bake.
    ///   Auto          as open() does, also an EXR file of channel Y
    ///   None          as openAny() does
    ///   other values  a picture of integers as R, G and B in linear light. Fails for OpenEXR and Radiance files, for values outside
    ///                 [0, 1], and for RGBM without alpha.
    static Result<BakeImage> openAs(const std::filesystem::path& file, LightEncoding encoding);
    /// Opens an EXR file, or a Radiance picture (.hdr, .pic), which has the channels R, G and B.
    static Result<BakeImage> open(const std::filesystem::path& file);
    /// Opens an image of any kind; 8 and 16 bits become [0, 1] without a curve. For a part of a bake that says what its values are. Of a
    /// grey picture R, G and B are equal, and so they are of an EXR file of channel Y, perhaps with alpha and channels of the surface.
    static Result<BakeImage> openAny(const std::filesystem::path& file);

    const std::filesystem::path& file() const { return file_; }
    /// Returns the file's name for errors.
    Subject subject() const { return file_; }
    const ExrInfo& info() const { return exr_ && !isGrey_ ? exr_->info() : pictureInfo_; }
    bool isEncoded() const { return isEncoded_; }
    /// Returns the number of rows that are cheap to read together.
    int tileHeight() const;
    /// Reads rows [firstRow, firstRow + rowCount) of channels that exist. Safe from several threads.
    Result<void> readRows(int firstRow, int rowCount, std::span<const ExrPlane> planes) const;
    /// Returns a digest of what is stored of rows: see ExrReader::storedDigest().
    Result<std::string> storedDigest(int firstRow, int rowCount) const;

private:
    static Result<BakeImage> openEncoded(const std::filesystem::path& file, LightEncoding encoding);
    static Result<BakeImage> openPicture(const std::filesystem::path& file);
    /// Gives R, G and B to an EXR file of channel Y.
    static BakeImage withColours(BakeImage image);
    explicit BakeImage(std::filesystem::path file) : file_(std::move(file)) {}

    std::filesystem::path file_;
    std::optional<ExrReader> exr_;
    bool isEncoded_ = false;
    bool isGrey_ = false;  ///< the EXR file has Y in place of R, G and B
    ExrInfo pictureInfo_;  ///< of a picture, and of an EXR file that is grey
    Image<glm::vec3> picture_;
    Image<float> alpha_;  ///< empty: the picture has none
};

/// Returns true if every channel of an image is one of a picture (R, G, B, A) or one that every bake may have (coverage.Y, normal.X/Y/Z),
/// and R, G and B are among them.
bool isPicture(const ExrInfo& info);

/// Opens the images of a bake of several files, of any kind. Fails at the first that is missing, that lacks R, G or B, or whose size is not
/// that of the first.
/// image  one of the files, which is open already; if it is encoded, it has to be the first
Result<std::vector<BakeImage>> openImages(BakeImage image, std::span<const std::filesystem::path> files);

}  // namespace lightcook::formats
