#include "pipeline/assets/light_map/worst_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <glm/gtc/type_precision.hpp>
#include <iterator>

#include "formats/png.h"
#include "pipeline/assets/light_map/checked_light_map.h"
#include "pipeline/assets/light_map/lit_row.h"
#include "pipeline/assets/light_map/rendered_view.h"
#include "pipeline/assets/preview.h"
#include "pipeline/graph/files.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

constexpr std::size_t kPlaces = 4;
constexpr int kCropSide = 24, kGap = 1, kPanels = 3;  ///< [pixels] of a picture: a texel is a pixel

/// Sets a row of each panel.
/// left  column of the map that texel 0 of the row is
void drawRow(const LitRow& lit, const formats::LightMapStrip& reference, int left, int y, double key,
             formats::Image<glm::u8vec3>& picture) {
    const int side = (picture.width() - (kPanels - 1) * kGap) / kPanels;
    for (int x = 0; x < side; ++x) {
        if (reference.covered.at(left + x, y) == 0) continue;
        picture.at(x, y) = toneMapped(lit.reference(x), key);
        picture.at(side + kGap + x, y) = toneMapped(lit.found(x), key);
        picture.at(2 * (side + kGap) + x, y) = heatOf(lit.visible(x));
    }
}

/// Draws the surroundings of a texel, and sets the light there.
Result<formats::Image<glm::u8vec3>> draw(const WorstTexel& texel, const CheckedLightMap& map, WorstPlacePicture& place) {
    LightMapSource& bake = map.bake;
    const int width = std::min(kCropSide, bake.width()), height = std::min(kCropSide, bake.height());
    const int left = std::clamp(texel.x - width / 2, 0, bake.width() - width),
              top = std::clamp(texel.y - height / 2, 0, bake.height() - height);
    LC_TRY(reference, bake.rows(top, height));
    const int firstRead = top / kRowAlignment * kRowAlignment;
    LC_TRY(texels, map.cooked.read(firstRead, top + height - firstRead));
    const auto seen = map.cooked.verifier().reconstruct(*texels, top, height, 1, &*reference);
    const double key = shownKey(map.viewing);
    formats::Image<glm::u8vec3> picture(kPanels * width + (kPanels - 1) * kGap, height, kOutside);
    LitRow lit(width, map.viewing);
    for (int y = 0; y < height; ++y) {
        for (int x = left; x < left + width; ++x)
            if (reference->covered.at(x, y) != 0) lit.set(x - left, reference->sh.at(x, y), seen.at(x, y), reference->normal.at(x, y));
        lit.compare();
        drawRow(lit, *reference, left, y, key, picture);
        if (top + y != texel.y) continue;
        place.normal = glm::dvec3(reference->normal.at(texel.x, y));
        place.reference = lit.reference(texel.x - left);
        place.found = lit.found(texel.x - left);
    }
    return picture;
}

}  // namespace

void WorstTexels::merge(const WorstTexels& other) {
    std::ranges::copy_if(other.texels_, std::back_inserter(texels_), [](const WorstTexel& texel) { return texel.visible >= 0; });
    std::ranges::sort(texels_, isWorse);
    if (texels_.size() > kKept) texels_.resize(kKept);
}

std::vector<WorstTexel> WorstTexels::apart(std::size_t count, int distance) const {
    std::vector<WorstTexel> chosen;
    for (const WorstTexel& texel : texels_) {
        if (chosen.size() == count) break;
        if (std::ranges::all_of(chosen, [&](const WorstTexel& other) {
                return std::abs(texel.x - other.x) > distance || std::abs(texel.y - other.y) > distance;
            }))
            chosen.push_back(texel);
    }
    return chosen;
}

/// Writes pictures into the action's folder: 24 x 24 texels of the bake, of the cooked map, and of the visible error between them, side by
/// side, at the exposure of the display; with triangles also a rendered view of each place. Errors below half of a just noticeable
/// difference get none.
Result<void> drawWorstPlaces(CheckedLightMap& map) {
    const ActionContext& context = map.context;
    std::vector<WorstPlacePicture>& places = map.worstPlaces;
    for (const WorstTexel& texel : map.texels.shown.worst.apart(kPlaces, kCropSide)) {
        if (texel.visible < kLeastShown) break;
        WorstPlacePicture place;
        place.file = fmt::format("preview/{}_worst_{}.png", context.action.asset, places.size() + 1);
        place.texel = {texel.x, texel.y};
        place.visible = static_cast<double>(texel.visible);
        LC_TRY(picture, draw(texel, map, place));
        LC_TRY(png, formats::encodePng(picture->view()));
        LC_CHECK(writeFile(context.folder / place.file, *png));
        if (!map.triangles.empty()) {
            LC_TRY(view, writeRenderedView(map, {texel.x, texel.y}, fmt::format("{}_view_{}", context.action.asset, places.size() + 1)));
            place.view = std::move(*view);
        }
        places.push_back(std::move(place));
    }
    return {};
}

}  // namespace lightcook::pipeline
