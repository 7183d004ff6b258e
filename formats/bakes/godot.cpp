#include "formats/bakes/godot.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "formats/bakes/exit_radiance.h"
#include "formats/bakes/images_reader.h"
#include "formats/digest.h"
#include "formats/read_file.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;

constexpr int kSlices = 4;  ///< of a page
/// |L1| is at most 4 L0, so p lies in a ball of radius 1/2 about 0.5: the largest length beyond it that a denoiser leaves, the share of
/// texels that may lie further out, and the largest mean of |p - 0.5| over its components, which is at most 1 / (2 sqrt(3)) in the ball.
constexpr double kLongest = 0.55, kMostOutside = 0.02, kLargestMean = 0.3;
/// Without light p is 0.5, and near it where L0 is so small that a half rounds it to 0. The share of such texels that may lie further off.
constexpr double kUnlit = 0.2, kMostUnpacked = 0.02;
/// Rows of a page that are looked at.
constexpr int kLookedAt = 32;

/// Factors of L0 and L1 in lambda_0 and lambda_1.
struct Reading {
    float first, linear;
};
constexpr Reading kAsShown = {kFirstOfExit, kLinearOfExit};
constexpr Reading kAsRadiance = {2 * kFirstOfExit, 0.75f * kLinearOfExit};

std::filesystem::path importFile(const std::filesystem::path& file) {
    return file.string() + ".import";
}

/// Returns true if whole pages of square slices are stacked.
bool isStackOfSquares(const ExrInfo& info) {
    return info.height % (std::int64_t{kSlices} * info.width) == 0;
}

/// Returns the number after a key in Godot's import settings of an array texture, if there are any.
std::optional<int> importedNumber(const std::filesystem::path& file, std::string_view key) {
    constexpr std::string_view kImporter = "importer=\"2d_array_texture\"";
    std::error_code code;
    if (!std::filesystem::is_regular_file(importFile(file), code)) return std::nullopt;
    const auto text = readWholeText(importFile(file));
    if (!text || text->find(kImporter) == std::string::npos) return std::nullopt;
    const std::size_t at = text->find(key);
    int slices = 0;
    if (at == std::string::npos) return std::nullopt;
    const char* const first = text->data() + at + key.size();
    const auto parsed = std::from_chars(first, text->data() + text->size(), slices);
    return parsed.ec == std::errc() && slices > 0 ? std::optional(slices) : std::nullopt;
}

/// Slices of a file: as its import settings say, else as many squares as are stacked if those make whole pages, else four.
int slicesOf(const std::filesystem::path& file, const ExrInfo& info) {
    const int squares = info.height / info.width;
    return importedSlices(file).value_or(isStackOfSquares(info) ? squares : kSlices);
}

/// Statistics that tell packed directions from flat pages.
class Packing {
public:
    /// p  the packed components of L1, minus 0.5
    void add(float light, const glm::dvec3& p) {
        const double length = glm::length(p);
        if (!std::isfinite(length) || !std::isfinite(light)) return;  // the conversion refuses it by texel
        if (light > 0) {
            ++lit_;
            sum_ += (std::abs(p.x) + std::abs(p.y) + std::abs(p.z)) / 3;
            outside_ += length > kLongest ? 1 : 0;
        } else {
            ++unlit_;
            // An atlas may be cleared to 0 around its charts.
            unpacked_ += length > kUnlit && p != glm::dvec3(-0.5) ? 1 : 0;
        }
    }
    std::optional<std::string> fault() const {
        const auto share = [](double part, std::int64_t whole) { return whole > 0 ? part / static_cast<double>(whole) : 0.0; };
        if (const double mean = share(sum_, lit_); mean > kLargestMean)
            return fmt::format("that differ from 0.5 by {:.2f} on average, expected at most {}", mean, kLargestMean);
        if (const double outside = share(static_cast<double>(outside_), lit_); outside > kMostOutside)
            return fmt::format("further than {} from 0.5 in {:.0f} % of the texels, expected a length of at most 0.5", kLongest,
                               100 * outside);
        if (const double unpacked = share(static_cast<double>(unpacked_), unlit_); unpacked > kMostUnpacked)
            return fmt::format("that are not 0.5 in {:.0f} % of the texels without light in slice 1, expected 0.5", 100 * unpacked);
        return std::nullopt;
    }

private:
    std::int64_t lit_ = 0, outside_ = 0, unlit_ = 0, unpacked_ = 0;
    double sum_ = 0;
};

class GodotReader final : public ImagesReader {
public:
    GodotReader(std::vector<BakeImage> images, SurfaceChannels surface, Reading reading, int slices)
        : ImagesReader(std::move(images), std::move(surface)), reading_(reading), sliceHeight_(ImagesReader::height() / slices) {}

    int height() const override { return ImagesReader::height() / kSlices; }
    std::optional<int> sliceCount() const override { return height() / sliceHeight_; }

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw = emptyStrip(rowCount);
        std::vector<ExrPlane> surfacePlanes;
        addSurface(raw, surfacePlanes);
        LC_CHECK(forEachRun(firstRow, rowCount, [&](int row, int count, int slice) {
            std::vector<ExrPlane> planes;
            if (slice == 0) planes = surfacePlanes;
            for (ExrPlane& plane : planes) plane.texels += row * plane.rowStride;
            // The coefficient of a slice has its index: 0, y, z, x.
            addColours(raw, static_cast<std::size_t>(slice), planes, row);
            return images().front().readRows(sourceRowOf(slice, firstRow + row), count, planes);
        }));
        for (ShRgb& sh : raw.sh.texels()) unpack(sh);
        return raw;
    }

    Result<std::string> storedDigest(int firstRow, int rowCount) const override {
        std::string digests = fmt::format("{}", sliceHeight_);
        bool isKnown = true;
        LC_CHECK(forEachRun(firstRow, rowCount, [&](int row, int count, int slice) -> Result<void> {
            LC_TRY(digest, ImagesReader::storedDigest(sourceRowOf(slice, firstRow + row), count));
            isKnown = isKnown && !digest->empty();
            digests += *digest;
            return {};
        }));
        return isKnown ? digestOfText(digests) : std::string();
    }

    std::optional<StoredNumber> placeOf(std::size_t coefficient, int colour, int x, int y) const override {
        return numberAt({0, colourName(colour)}, x, sourceRowOf(static_cast<int>(coefficient), y));
    }

    /// Refuses a stack of flat pages: their values are no packed ones. Looks at rows of the first page.
    Result<void> checkPacking() const {
        Packing packing;
        const int rows = std::min(kLookedAt, sliceHeight_);
        for (int index = 0; index < rows; ++index) {
            RawStrip row = emptyStrip(1);
            for (int slice = 0; slice < kSlices; ++slice) {
                std::vector<ExrPlane> planes;
                addColours(row, static_cast<std::size_t>(slice), planes);
                const int sourceRow = slice * sliceHeight_ + (2 * index + 1) * sliceHeight_ / (2 * rows);
                LC_CHECK(images().front().readRows(sourceRow, 1, planes));
            }
            for (const ShRgb& texel : row.sh.texels())
                for (int colour = 0; colour < 3; ++colour)
                    packing.add(texel[0][colour], glm::dvec3(texel[1][colour], texel[2][colour], texel[3][colour]) - 0.5);
        }
        const std::optional<std::string> fault = packing.fault();
        if (!fault) return {};
        return failure(ErrorCode::WrongShape, images().front().subject(),
                       fmt::format("found slices 2 to 4 {}: packed directions of Godot are around 0.5. A bake of Godot 4.0 to 4.3, which "
                                   "packs none? Bake it again with Godot 4.4 or later. Flat pages? Give each its own file, with bake = "
                                   "\"flat\"",
                                   *fault));
    }

private:
    /// Calls work(row, count, slice) for the rows [firstRow + row, firstRow + row + count) of each slice that lie together in the file.
    template <class Work>
    Result<void> forEachRun(int firstRow, int rowCount, Work work) const {
        for (int row = 0; row < rowCount;) {
            const int count = std::min(rowCount - row, sliceHeight_ - (firstRow + row) % sliceHeight_);
            for (int slice = 0; slice < kSlices; ++slice) LC_CHECK(work(row, count, slice));
            row += count;
        }
        return {};
    }
    /// Returns the row of the file that holds a slice of a row of the map.
    int sourceRowOf(int slice, int row) const { return (row / sliceHeight_ * kSlices + slice) * sliceHeight_ + row % sliceHeight_; }

    /// Replaces L0 and the packed directions of a texel by coefficients.
    void unpack(ShRgb& sh) const {
        for (std::size_t i = 1; i < kSlices; ++i) sh[i] = reading_.linear * 8 * sh[0] * (sh[i] - 0.5f);
        sh[0] *= reading_.first;
    }

    Reading reading_;
    int sliceHeight_ = 0;  ///< [texels]
};

Result<std::unique_ptr<BakeReader>> openAs(Reading reading, BakeImage image) {
    const int slices = slicesOf(image.file(), image.info()), height = image.info().height;
    if (slices % kSlices != 0)
        return failure(ErrorCode::WrongShape, importFile(image.file()),
                       fmt::format("found slices/vertical={}, expected a multiple of {}: L0 and three directions a page. A flat light map? "
                                   "Set bake = \"flat\"",
                                   slices, kSlices));
    if (const int columns = importedNumber(image.file(), "slices/horizontal=").value_or(1); columns != 1)
        return failure(ErrorCode::WrongShape, importFile(image.file()),
                       fmt::format("found slices/horizontal={}, expected 1: slices from top to bottom", columns));
    if (height % slices != 0)
        return failure(ErrorCode::WrongShape, image.subject(),
                       fmt::format("found a height of {} texels, expected a multiple of {}: slices from top to bottom", height, slices));
    Result<SurfaceChannels> surface = SurfaceChannels::of(image, "A");
    if (!surface) return tl::make_unexpected(surface.error());
    auto reader = std::make_unique<GodotReader>(onlyImage(std::move(image)), std::move(*surface), reading, slices);
    LC_CHECK(reader->checkPacking());
    return reader;
}

}  // namespace

std::optional<int> importedSlices(const std::filesystem::path& file) {
    return importedNumber(file, "slices/vertical=");
}

BakeMatch matchGodot(const std::filesystem::path& file, const ExrInfo& info) {
    constexpr int kNumbers = 12;
    if (!isPicture(info)) return {};
    // Another number of slices is that of a flat map.
    if (const auto slices = importedSlices(file))
        return {*slices % kSlices == 0 ? BakeMatch::Kind::Certain : BakeMatch::Kind::OnlyNamed, kNumbers,
                fmt::format("slices/vertical={} in {}", *slices, importFile(file).filename().string())};
    const int slices = slicesOf(file, info);
    return {
        isStackOfSquares(info) ? BakeMatch::Kind::Possible : BakeMatch::Kind::OnlyNamed, kNumbers,
        fmt::format("{} slices of {} x {} texels", slices == kSlices ? "four" : std::to_string(slices), info.width, info.height / slices)};
}

std::vector<std::filesystem::path> filesBesideGodot(const std::filesystem::path& file) {
    return {importFile(file)};
}

Result<std::unique_ptr<BakeReader>> openGodot(BakeImage image) {
    return openAs(kAsShown, std::move(image));
}

Result<std::unique_ptr<BakeReader>> openGodotRadiance(BakeImage image) {
    return openAs(kAsRadiance, std::move(image));
}

}  // namespace lightcook::formats
