#include "formats/bakes/flat.h"

#include <fmt/format.h>

#include <cstdint>
#include <utility>

#include "formats/bakes/exit_radiance.h"
#include "formats/bakes/godot.h"
#include "formats/bakes/images_reader.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;

class FlatReader final : public ImagesReader {
public:
    FlatReader(std::vector<BakeImage> images, SurfaceChannels surface) : ImagesReader(std::move(images), std::move(surface)) {}

    std::optional<int> sliceCount() const override { return importedSlices(images().front().file()); }

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw = emptyStrip(rowCount);
        std::vector<ExrPlane> planes;
        addColours(raw, 0, planes);
        addSurface(raw, planes);
        LC_CHECK(images().front().readRows(firstRow, rowCount, planes));
        for (ShRgb& sh : raw.sh.texels()) sh[0] *= kFirstOfExit;
        return raw;
    }
};

}  // namespace

BakeMatch matchFlat(const std::filesystem::path&, const ExrInfo& info) {
    if (!isPicture(info)) return {};
    // The six faces of a probe, which is the usual mistake.
    const bool isStrip = std::int64_t{6} * info.width == info.height || std::int64_t{6} * info.height == info.width;
    return {isStrip ? BakeMatch::Kind::OnlyNamed : BakeMatch::Kind::Possible, 3,
            fmt::format("a picture of {} x {} texels", info.width, info.height)};
}

Result<std::unique_ptr<BakeReader>> openFlat(BakeImage image) {
    Result<SurfaceChannels> surface = SurfaceChannels::of(image, "A");
    if (!surface) return tl::make_unexpected(surface.error());
    return std::make_unique<FlatReader>(onlyImage(std::move(image)), std::move(*surface));
}

}  // namespace lightcook::formats
