// The part that readers of bakes share whose light depends on the surface: normals come from the mesh, and coverage where there is none.
#pragma once

#include <utility>
#include <vector>

#include "formats/bakes/images_reader.h"
#include "formats/bakes/surface_frames.h"

namespace lightcook::formats {

class OnSurfaceReader : public ImagesReader {
public:
    bool hasNormals() const override { return true; }
    bool hasCoverage() const override { return true; }

protected:
    OnSurfaceReader(std::vector<BakeImage> images, SurfaceChannels surface, SurfaceFrames frames)
        : ImagesReader(std::move(images), std::move(surface)), frames_(std::move(frames)) {}

    /// Replaces the normals of a strip by those of the mesh, and takes texels without a surface from its coverage. Returns the frames.
    Image<SurfaceFrame> putOnSurface(RawStrip& raw, int firstRow) const {
        Image<SurfaceFrame> frames = frames_.rows(firstRow, raw.sh.height());
        if (raw.coverage.width() == 0) raw.coverage = Image<float>(width(), raw.sh.height(), 1);
        raw.normal = Image<glm::vec3>(width(), raw.sh.height());
        for (int y = 0; y < raw.sh.height(); ++y)
            for (int x = 0; x < width(); ++x) {
                raw.normal.at(x, y) = frames.at(x, y).normal;
                if (!frames.at(x, y).isSurface()) raw.coverage.at(x, y) = 0;
            }
        return frames;
    }

private:
    SurfaceFrames frames_;
};

/// Opens a reader of class Reader, whose constructor takes the images, the channels of the first one, the frames, and `more`.
template <class Reader, class... More>
Result<std::unique_ptr<BakeReader>> openOnSurface(BakeImage image, std::span<const std::filesystem::path> files, const BakeSurface& surface,
                                                  const More&... more) {
    Result<std::vector<BakeImage>> images = openImages(std::move(image), files);
    if (!images) return tl::make_unexpected(images.error());
    Result<SurfaceChannels> channels = SurfaceChannels::of(images->front(), "A");
    if (!channels) return tl::make_unexpected(channels.error());
    Result<SurfaceFrames> frames =
        SurfaceFrames::load(surface.mesh, images->front().info().width, images->front().info().height, {}, surface.places);
    if (!frames) return tl::make_unexpected(frames.error());
    if (!surface.axes.isIdentity()) frames->turn(surface.axes.inverse());
    return std::make_unique<Reader>(std::move(*images), std::move(*channels), std::move(*frames), more...);
}

}  // namespace lightcook::formats
