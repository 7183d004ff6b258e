// Square images placed on pages of a limited size, as bakers place those of objects.
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace lightcook::atlas {

/// Sides of images and pages are multiples of this [texels]: the side of a compressed block.
inline constexpr int kPageStep = 4;

struct PlaceOnPage {
    std::size_t page = 0;
    glm::ivec2 first{0};  ///< texel of the page
};

struct Pages {
    std::vector<glm::ivec2> sizes;    ///< of each page [texels]
    std::vector<PlaceOnPage> places;  ///< of each image
};

/// Places images, the largest first, each at the lowest row, then column, that is free down to it (skyline, bottom left). Images that fit
/// on one page get the smallest page of those widths that are tried. Otherwise a page of the largest size takes what it can, and the images
/// that are left are placed in the same way.
/// sides    of the images [texels], at most `largest`
/// padding  texels between images
/// largest  side of a page [texels]
Pages packSquares(std::span<const int> sides, int padding, int largest);

}  // namespace lightcook::atlas
