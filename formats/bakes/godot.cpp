#include "formats/bakes/godot.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "formats/bakes/exit_radiance.h"
#include "formats/bakes/images_reader.h"
#include "formats/read_file.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;

constexpr int kSlices = 4;  ///< of a page
/// Largest mean of |p - 0.5| over the slices of L1. |L1| is at most 4 L0, so p lies in a ball of radius 1/2, where the mean of a
/// component is at most 1 / (2 sqrt(3)).
constexpr double kLargestMean = 0.3;

/// Factors of L0 and L1 in lambda_0 and lambda_1.
struct Reading {
    float first, linear;
};
constexpr Reading kAsShown = {kFirstOfExit, kLinearOfExit};
constexpr Reading kAsRadiance = {2 * kFirstOfExit, 0.75f * kLinearOfExit};

std::filesystem::path importFile(const std::filesystem::path& file) {
    return file.string() + ".import";
}

/// Returns the number after "slices/vertical=" in Godot's import settings of an array texture, if there are any.
std::optional<int> importedSlices(const std::filesystem::path& file) {
    constexpr std::string_view kImporter = "importer=\"2d_array_texture\"", kVertical = "slices/vertical=";
    std::error_code code;
    if (!std::filesystem::is_regular_file(importFile(file), code)) return std::nullopt;
    const auto text = readWholeText(importFile(file));
    if (!text || text->find(kImporter) == std::string::npos) return std::nullopt;
    const std::size_t at = text->find(kVertical);
    int slices = 0;
    if (at == std::string::npos) return std::nullopt;
    const char* const first = text->data() + at + kVertical.size();
    const auto parsed = std::from_chars(first, text->data() + text->size(), slices);
    return parsed.ec == std::errc() && slices > 0 ? std::optional(slices) : std::nullopt;
}

/// Slices of a file: as its import settings say, else four.
int slicesOf(const std::filesystem::path& file) {
    return importedSlices(file).value_or(kSlices);
}

class GodotReader final : public ImagesReader {
public:
    GodotReader(std::vector<BakeImage> images, SurfaceChannels surface, Reading reading, int slices)
        : ImagesReader(std::move(images), std::move(surface)), reading_(reading), sliceHeight_(ImagesReader::height() / slices) {}

    int height() const override { return ImagesReader::height() / kSlices; }

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw = emptyStrip(rowCount);
        std::vector<ExrPlane> surfacePlanes;
        addSurface(raw, surfacePlanes);
        for (int row = 0; row < rowCount;) {
            const int page = (firstRow + row) / sliceHeight_, rowOfPage = (firstRow + row) % sliceHeight_;
            const int count = std::min(rowCount - row, sliceHeight_ - rowOfPage);
            for (int slice = 0; slice < kSlices; ++slice) {
                std::vector<ExrPlane> planes;
                if (slice == 0) planes = surfacePlanes;
                for (ExrPlane& plane : planes) plane.texels += row * plane.rowStride;
                // The coefficient of a slice has its index: 0, y, z, x.
                addColours(raw, static_cast<std::size_t>(slice), planes, row);
                const int sourceRow = (page * kSlices + slice) * sliceHeight_ + rowOfPage;
                if (const auto read = images().front().readRows(sourceRow, count, planes); !read) return tl::make_unexpected(read.error());
            }
            row += count;
        }
        for (ShRgb& sh : raw.sh.texels()) unpack(sh);
        return raw;
    }

    /// Refuses a stack of flat pages: their values are no packed ones. Looks at the middle row of each slice of the first page.
    Result<void> checkPacking() const {
        const auto rows = read(sliceHeight_ / 2, 1);
        if (!rows) return tl::make_unexpected(rows.error());
        double sum = 0;
        std::int64_t count = 0;
        for (const ShRgb& sh : rows->sh.texels())
            for (int colour = 0; colour < 3; ++colour) {
                const double scale = 8 * static_cast<double>(sh[0][colour] / reading_.first * reading_.linear);
                const double total = std::abs(static_cast<double>(sh[1][colour])) + std::abs(static_cast<double>(sh[2][colour])) +
                                     std::abs(static_cast<double>(sh[3][colour]));
                if (!(scale > 0) || !std::isfinite(total / scale)) continue;  // black; or no light, which the conversion refuses by texel
                sum += total / scale;
                count += kSlices - 1;
            }
        if (count == 0 || sum <= kLargestMean * static_cast<double>(count)) return {};
        return failure(
            ErrorCode::WrongShape, images().front().subject(),
            fmt::format("found slices 2 to 4 that differ from 0.5 by {:.2f} on average, expected at most {}: packed directions of "
                        "Godot are around 0.5. Flat pages? Give each its own file, with bake = \"flat\"",
                        sum / static_cast<double>(count), kLargestMean));
    }

private:
    /// Replaces L0 and the packed directions of a texel by coefficients.
    void unpack(ShRgb& sh) const {
        for (std::size_t i = 1; i < kSlices; ++i) sh[i] = reading_.linear * 8 * sh[0] * (sh[i] - 0.5f);
        sh[0] *= reading_.first;
    }

    Reading reading_;
    int sliceHeight_ = 0;  ///< [texels]
};

Result<std::unique_ptr<BakeReader>> openAs(Reading reading, BakeImage image) {
    const int slices = slicesOf(image.file()), height = image.info().height;
    if (slices % kSlices != 0)
        return failure(ErrorCode::WrongShape, importFile(image.file()).string(),
                       fmt::format("found slices/vertical={}, expected a multiple of {}: L0 and three directions a page. A flat light map? "
                                   "Set bake = \"flat\"",
                                   slices, kSlices));
    if (height % slices != 0)
        return failure(ErrorCode::WrongShape, image.subject(),
                       fmt::format("found a height of {} texels, expected a multiple of {}: slices from top to bottom", height, slices));
    Result<SurfaceChannels> surface = SurfaceChannels::of(image, "A");
    if (!surface) return tl::make_unexpected(surface.error());
    auto reader = std::make_unique<GodotReader>(onlyImage(std::move(image)), std::move(*surface), reading, slices);
    if (const auto packed = reader->checkPacking(); !packed) return tl::make_unexpected(packed.error());
    return reader;
}

}  // namespace

BakeMatch matchGodot(const std::filesystem::path& file, const ExrInfo& info) {
    constexpr int kNumbers = 12;
    if (!isPicture(info)) return {};
    if (const auto slices = importedSlices(file); slices && *slices % kSlices == 0)
        return {BakeMatch::Kind::Certain, kNumbers, fmt::format("slices/vertical={} in {}", *slices, importFile(file).filename().string())};
    const bool isStack = std::int64_t{kSlices} * info.width == info.height;
    return {isStack ? BakeMatch::Kind::Possible : BakeMatch::Kind::OnlyNamed, kNumbers,
            fmt::format("four slices of {} x {} texels", info.width, info.height / kSlices)};
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
