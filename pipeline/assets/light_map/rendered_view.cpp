#include "pipeline/assets/light_map/rendered_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/type_precision.hpp>
#include <map>
#include <span>
#include <vector>

#include "formats/png.h"
#include "lighting/display.h"
#include "lighting/radiometry.h"
#include "pipeline/assets/light_map/bake_filter.h"
#include "pipeline/assets/light_map/checked_light_map.h"
#include "pipeline/assets/light_map/mesh_view.h"
#include "pipeline/assets/preview.h"
#include "pipeline/graph/files.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

constexpr int kSide = 192;                         ///< [pixels]
constexpr double kRadiusTexels = 20;               ///< half of the picture's side at the place
constexpr int kNear = 24;                          ///< [rows] around the texel, whose places are the finer ones
constexpr int kFinePlaces = 4, kCoarsePlaces = 2;  ///< places a texel at which the cooked map is decoded

/// A pixel and the place of the map that it shows.
struct LitPixel {
    int x = 0, y = 0;
    glm::dvec2 at{0};  ///< [texels], (0.5, 0.5) is the centre of the first
};

/// Decodes places of the cooked map, in rows of texels that come in increasing order.
class CookedPlaces {
public:
    explicit CookedPlaces(const CookedLightMapReader& cooked) : cooked_(cooked) {}

    /// Returns some columns of the places of a row of texels, which are `places` x `places` of each.
    /// surface  rows of the bake that hold this one
    Result<formats::Image<lighting::ShRgb>> row(int row, int places, const formats::LightMapStrip& surface, std::span<const int> columns) {
        const int first = std::max(0, row / kRowAlignment * kRowAlignment - kRowAlignment);
        if (!texels_ || texels_->firstRow != first) {
            LC_TRY(read, cooked_.read(first, std::min(3 * kRowAlignment, cooked_.height() - first)));
            texels_ = std::move(*read);
        }
        return cooked_.verifier().reconstructColumns(*texels_, row, 1, places, &surface, columns);
    }

private:
    const CookedLightMapReader& cooked_;
    std::optional<verify::DecodedLightMapRows> texels_;
};

/// The bake at a place.
struct BakedPlace {
    lighting::ShRgb sh{};
    glm::vec3 normal{0};
    bool isCovered = false;
};
/// at  [texels], (0.5, 0.5) is the centre of the first
BakedPlace bakedAt(const formats::LightMapStrip& strip, const glm::dvec2& at) {
    BakedPlace place;
    float sum = 0;
    forEachCoveredAround(strip, at - 0.5, [&](int x, int row, double share) {
        const auto weight = static_cast<float>(share);
        sum += weight;
        for (std::size_t k = 0; k < place.sh.size(); ++k) place.sh[k] += weight * strip.sh.at(x, row)[k];
        place.normal += weight * strip.normal.at(x, row);
    });
    const float length = glm::length(place.normal);
    if (!(sum > 0) || !(length > 0)) return place;
    for (auto& coefficient : place.sh) coefficient /= sum;
    place.normal /= length;
    place.isCovered = true;
    return place;
}

/// Returns the pixels that show a place of the map, by their rows of texels.
/// uvs   of the pixels
/// size  of the map [texels]
std::map<int, std::vector<LitPixel>> pixelsByRow(const formats::Image<glm::dvec2>& uvs, const glm::ivec2& size) {
    std::map<int, std::vector<LitPixel>> rows;
    for (int y = 0; y < uvs.height(); ++y)
        for (int x = 0; x < uvs.width(); ++x) {
            const glm::dvec2 at = uvs.at(x, y) * glm::dvec2(size);
            if (!(at.x >= 0 && at.y >= 0 && at.x < size.x && at.y < size.y)) continue;
            rows[static_cast<int>(at.y)].push_back({x, y, at});
        }
    return rows;
}

/// Returns the column of places that a pixel shows.
/// places  of a texel along each axis
/// width   of the map [texels]
int columnOf(const LitPixel& pixel, int places, int width) {
    return std::min(static_cast<int>(pixel.at.x * places), places * width - 1);
}

/// Returns the columns of places that pixels show, in increasing order.
std::vector<int> columnsOf(const std::vector<LitPixel>& pixels, int places, int width) {
    std::vector<int> columns;
    for (const LitPixel& pixel : pixels) columns.push_back(columnOf(pixel, places, width));
    std::ranges::sort(columns);
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    return columns;
}

/// A view lit by the bake and by the cooked map.
struct LitView {
    formats::Image<glm::u8vec3> reference{kSide, kSide, kOutside}, found{kSide, kSide, kOutside};
};

/// Lights the pixels that show places of a map.
/// centreRow  row of the map around which places are the finer ones
Result<LitView> lightView(const CheckedLightMap& map, const std::map<int, std::vector<LitPixel>>& pixelsOfRows, int centreRow) {
    const double key = shownKey(map.viewing);
    LitView view;
    CookedPlaces places(map.cooked);
    for (const auto& [row, pixels] : pixelsOfRows) {
        const int first = std::max(0, row - 1);
        LC_TRY(baked, map.bake.rows(first, std::min(row + 2, map.bake.height()) - first));
        const int count = std::abs(row - centreRow) <= kNear ? kFinePlaces : kCoarsePlaces;
        const std::vector<int> columns = columnsOf(pixels, count, map.bake.width());
        LC_TRY(decoded, places.row(row, count, *baked, columns));
        for (const LitPixel& pixel : pixels) {
            const BakedPlace lit = bakedAt(*baked, pixel.at);
            if (!lit.isCovered) continue;
            const auto column = std::ranges::lower_bound(columns, columnOf(pixel, count, map.bake.width()));
            const int x = static_cast<int>(column - columns.begin()),
                      y = std::clamp(static_cast<int>((pixel.at.y - row) * count), 0, decoded->height() - 1);
            const auto shown = [&](const lighting::ShRgb& sh) {
                return toneMapped(lighting::lambertExitRadiance(sh, lit.normal, glm::vec3(1)).value, key);
            };
            view.reference.at(pixel.x, pixel.y) = shown(lit.sh);
            view.found.at(pixel.x, pixel.y) = shown(decoded->at(x, y));
        }
    }
    return view;
}

Result<void> writePng(const formats::Image<glm::u8vec3>& picture, const std::filesystem::path& file) {
    LC_TRY(png, formats::encodePng(picture.view()));
    return writeFile(file, *png);
}

}  // namespace

double shownKey(const verify::Viewing& viewing) {
    return lighting::kKeyOfDiffuseWhite * lighting::kDiffuseWhite / viewing.display.nitsPerUnit;
}

Result<std::optional<RenderedView>> writeRenderedView(const CheckedLightMap& map, const glm::ivec2& texel, const std::string& name) {
    const glm::ivec2 size(map.bake.width(), map.bake.height());
    const auto place = placeAt(map.triangles, (glm::dvec2(texel) + 0.5) / glm::dvec2(size), size);
    if (!place) return std::optional<RenderedView>();
    RenderedView view;
    const MeshCamera camera = cameraInFrontOf(map.triangles, *place, kRadiusTexels * place->texelSide, view.distance);
    LC_TRY(lit, lightView(map, pixelsByRow(rasterized(map.triangles, camera, kSide), size), texel.y));
    view.reference = "preview/" + name + "_bake.png";
    view.cooked = "preview/" + name + "_cooked.png";
    view.position = place->position;
    view.normal = place->normal;
    LC_CHECK(writePng(lit->reference, map.context.folder / view.reference));
    LC_CHECK(writePng(lit->found, map.context.folder / view.cooked));
    return std::optional(std::move(view));
}

}  // namespace lightcook::pipeline
