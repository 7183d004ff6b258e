// Conversion of a bake to canonical form, which every bake format shares: no Condon-Shortley signs, incident radiance in radiometric
// units, world axes, scene-linear working colour. Texels that cannot be light are refused or repaired before the conversion. At last light
// and normals are turned into the axes that the description asks for (LightMapDescription::outputAxes).
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "formats/bakes/bake_reader.h"
#include "formats/light_map.h"
#include "lighting/sh.h"

namespace lightcook::formats {

/// The linear map from the coefficients of a file to canonical ones, in this order: signs, quantity and units, frame, axes, colour. Leaves
/// every bit as it is if the file is canonical already.
class CanonicalConversion {
public:
    CanonicalConversion(const LightMapDescription& description, const LinearConversion& colors);

    bool isIdentity() const { return !flipsPhase_ && !scales_ && !rotates_ && !axes_ && !convertsColor_; }
    bool convertsColor() const { return convertsColor_; }
    /// Returns the largest length of a stored band relative to stored sh00, for light that is nowhere negative. For radiance it is
    /// sqrt(2 l + 1), which a point light reaches.
    float longestBand(std::size_t degree) const;

    /// normal  unit, world; used if the file's frame is tangent
    lighting::ShRgb operator()(lighting::ShRgb sh, const glm::vec3& normal) const;

private:
    bool flipsPhase_ = false, rotates_ = false, convertsColor_ = false, scales_ = false;
    lighting::ShBands bandFactors_{1.0, 1.0, 1.0};
    glm::mat3 workingFromSource_{1.0f};
    BakeAxes fileFromMesh_;
    std::optional<lighting::ShRotation> axes_;  ///< from the axes of the file to those of the mesh; none: they are the same
};

/// Checks and converts strips of one file.
class Canonicalizer {
public:
    /// file          for errors
    /// normalAxes    of the normals that the reader gives, against those of the mesh
    Canonicalizer(Subject file, const LightMapDescription& description, const LinearConversion& colors, const BakeAxes& normalAxes)
        : file_(std::move(file)),
          repairs_(description.repair),
          isCompressed_(description.isCompressed),
          normalAxes_(normalAxes),
          conversion_(description, colors),
          outputAxes_(description.outputAxes) {
        for (std::size_t degree = 0; degree < longestBands_.size(); ++degree) longestBands_[degree] = conversion_.longestBand(degree);
        if (!outputAxes_.isIdentity()) output_.emplace(outputAxes_.matrix());
    }

    /// Returns a strip that `reader` read, in canonical form. Fails at the first covered texel that is no light, unless the description
    /// asks for repair or, of finite values, says that the map was compressed.
    Result<LightMapStrip> operator()(RawStrip raw, int firstRow, const BakeReader& reader) const;
    /// Returns where a colour of a coefficient of texel (x, y) of the map is stored, for errors: "map.exr, channel sh00.R, texel (3, 4)".
    Subject nameOf(std::size_t coefficient, int colour, int x, int y, const BakeReader& reader) const;

private:
    Result<bool> isCovered(const RawStrip& raw, int x, int y, LightMapStrip& strip, const BakeReader& reader) const;
    Result<std::uint32_t> chartAt(const RawStrip& raw, int x, int y, const LightMapStrip& strip) const;
    Result<void> checkStored(std::uint8_t negative, int x, int y, LightMapStrip& strip, const BakeReader& reader) const;
    Result<void> checkTexel(lighting::ShRgb& sh, int x, int y, float brightest, LightMapStrip& strip, const BakeReader& reader) const;
    Result<void> checkBandLengths(lighting::ShRgb& sh, int x, int y, float brightest, LightMapStrip& strip, const BakeReader& reader) const;
    Result<void> convert(lighting::ShRgb& sh, int x, int y, LightMapStrip& strip, const BakeReader& reader) const;
    tl::unexpected<Error> refuse(ErrorCode code, const std::string& channel, int x, int y, std::string detail) const;
    /// Refuses a colour of a coefficient of texel (x, y) of the map, by the place where the file stores it.
    /// expected  what is expected in place of `value`
    tl::unexpected<Error> refuseNumber(ErrorCode code, std::size_t coefficient, int colour, int x, int y, float value,
                                       const std::string& expected, const BakeReader& reader) const;
    StoredNumber placeOf(std::size_t coefficient, int colour, int x, int y, const BakeReader& reader) const;

    Subject file_;
    bool repairs_ = false, isCompressed_ = false;
    BakeAxes normalAxes_;
    CanonicalConversion conversion_;
    std::array<double, 3> longestBands_{};  ///< CanonicalConversion::longestBand
    BakeAxes outputAxes_;
    std::optional<lighting::ShRotation> output_;  ///< from the axes of the mesh to those of the strips; none: they are the same
};

}  // namespace lightcook::formats
