#include "formats/bakes/rnm.h"

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <string_view>
#include <utility>

#include "formats/bakes/file_set.h"
#include "formats/bakes/on_surface.h"

namespace lightcook::formats {
namespace {

using lighting::Sh;
using lighting::ShRgb;

constexpr std::size_t kDirectionCount = kRnmEndings.size();
using Lobes = std::array<Sh, kDirectionCount>;

/// Coefficients of R_0 = 1 in tangent space that are not zero: even in y, as b_0 is. tests/formats/bakes/rnm_test.cpp derives them.
struct FirstLobe {
    float constant, z, x, zz, xz, xx;  ///< coefficients 0, 2, 3, 6, 7, 8
};
constexpr FirstLobe kBakeryLobe = {1.22852f, 0.30888f, 1.19369f, 0.82550f, 1.75134f, 1.14411f};
constexpr FirstLobe kSourceLobe = {1.1816359f, 0, 1.50133f, 0, 1.0f, 1.92102f};

/// Returns the lobes of b_0, b_1 and b_2: the first one turned by 120 degrees about z, either way. The y of the basis points down a
/// picture, as the green of Source's normal maps does (Bakery's shader negates theirs); that of the frames points up.
constexpr Lobes lobesOf(const FirstLobe& first) {
    constexpr float kHalfRoot3 = 0.8660254f;
    Lobes lobes{};
    for (std::size_t i = 0; i < kDirectionCount; ++i) {
        const float cosine = i == 0 ? 1 : -0.5f, sine = i == 0 ? 0 : i == 1 ? -kHalfRoot3 : kHalfRoot3;
        // Twice the angle is the opposite angle.
        lobes[i] = {first.constant,  first.x * sine, first.z,           first.x * cosine, -first.xx * sine,
                    first.xz * sine, first.zz,       first.xz * cosine, first.xx * cosine};
    }
    return lobes;
}

class RnmReader final : public OnSurfaceReader {
public:
    RnmReader(std::vector<BakeImage> images, SurfaceChannels surface, SurfaceFrames frames, const Lobes& lobes)
        : OnSurfaceReader(std::move(images), std::move(surface), std::move(frames)), lobes_(lobes) {}

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw = emptyStrip(rowCount);
        for (std::size_t image = 0; image < kDirectionCount; ++image) {
            std::vector<ExrPlane> planes;
            if (image == 0) addSurface(raw, planes);
            addColours(raw, image, planes);
            LC_CHECK(images()[image].readRows(firstRow, rowCount, planes));
        }
        const Image<SurfaceFrame> frames = putOnSurface(raw, firstRow);
        for (int y = 0; y < rowCount; ++y)
            for (int x = 0; x < width(); ++x) {
                ShRgb& sh = raw.sh.at(x, y);
                if (const std::uint8_t colours = removeNegative(sh); colours != 0) {
                    if (raw.negative.width() == 0) raw.negative = Image<std::uint8_t>(width(), rowCount);
                    raw.negative.at(x, y) = colours;
                }
                sh = decoded(sh, frames.at(x, y));
            }
        return raw;
    }

private:
    /// Sets negative numbers of a texel to 0. Returns the colours in which one was more than rounding (RawStrip::negative).
    static std::uint8_t removeNegative(ShRgb& stored) {
        constexpr float kRounding = 1e-6f;
        unsigned colours = 0;
        for (std::size_t direction = 0; direction < kDirectionCount; ++direction)
            for (int colour = 0; colour < 3; ++colour) {
                float& light = stored[direction][colour];
                if (!(light < 0)) continue;  // NaN stays, and is refused by texel
                if (light < -kRounding) colours |= 1u << colour;
                light = 0;
            }
        return static_cast<std::uint8_t>(colours);
    }

    ShRgb decoded(const ShRgb& stored, const SurfaceFrame& frame) const {
        if (!frame.isSurface()) return {};
        ShRgb inTangents{};
        for (std::size_t direction = 0; direction < kDirectionCount; ++direction)
            for (std::size_t i = 0; i < inTangents.size(); ++i) inTangents[i] += lobes_[direction][i] * stored[direction];
        const glm::dmat3 worldFromTangents(frame.tangent, frame.bitangent, frame.normal);
        return lighting::ShRotation(worldFromTangents).apply(inTangents);
    }

    Lobes lobes_;
};

constexpr Lobes kBakeryLobes = lobesOf(kBakeryLobe), kSourceLobes = lobesOf(kSourceLobe);

BakeMatch matchAs(const std::filesystem::path& file, const ExrInfo& info, std::string_view format) {
    const auto files = filesBesideRnm(file);
    if (files.empty() || !isPicture(info)) return {};
    return matchFiles(file, files, 3 * static_cast<int>(files.size()), format, FileKinds::Mixed);
}

}  // namespace

BakeMatch matchBakeryRnm(const std::filesystem::path& file, const ExrInfo& info) {
    return matchAs(file, info, "bakery-rnm");
}

BakeMatch matchSourceRnm(const std::filesystem::path& file, const ExrInfo& info) {
    BakeMatch match = matchAs(file, info, "source-rnm");
    if (match.kind == BakeMatch::Kind::Certain) match.kind = BakeMatch::Kind::OnlyNamed;
    return match;
}

std::vector<std::filesystem::path> filesBesideRnm(const std::filesystem::path& file) {
    return filesOfMixedSet(file, kRnmEndings);
}

Result<std::unique_ptr<BakeReader>> openBakeryRnm(BakeImage image, const BakeSurface& surface) {
    const auto files = filesBesideRnm(image.file());
    return openOnSurface<RnmReader>(std::move(image), files, surface, kBakeryLobes);
}

Result<std::unique_ptr<BakeReader>> openSourceRnm(BakeImage image, const BakeSurface& surface) {
    const auto files = filesBesideRnm(image.file());
    return openOnSurface<RnmReader>(std::move(image), files, surface, kSourceLobes);
}

}  // namespace lightcook::formats
