#include "atlas/pages.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <numeric>
#include <optional>
#include <utility>

namespace lightcook::atlas {
namespace {

/// Widths of a page that are tried: their number, and their range relative to the side of a square that the images would fill.
constexpr int kPageWidths = 32;
constexpr double kLeastPageWidth = 0.7, kLargestPageWidth = 1.4;

/// The first free row of each column of a page. Lengths are in steps of kPageStep.
class Skyline {
public:
    explicit Skyline(int columns) : heights_(static_cast<std::size_t>(columns), 0) {}

    std::optional<glm::ivec2> place(int side, int rows) {
        std::optional<glm::ivec2> best;
        for (auto begin = heights_.begin(); heights_.end() - begin >= side;) {
            // Each window with the highest column is as high: the next one to try begins behind the last of these.
            auto highest = begin;
            for (auto column = begin; column != begin + side; ++column)
                if (*column >= *highest) highest = column;
            if (!best || *highest < best->y) best = glm::ivec2(begin - heights_.begin(), *highest);
            begin = highest + 1;
        }
        if (!best || best->y + side > rows) return std::nullopt;
        std::fill_n(heights_.begin() + best->x, side, best->y + side);
        return best;
    }

private:
    std::vector<int> heights_;
};

/// One page and the images that have no place on it.
struct Filled {
    glm::ivec2 size{0};                                        ///< [texels]
    std::vector<std::pair<std::size_t, glm::ivec2>> places{};  ///< images with their first texels
    std::vector<std::size_t> left{};

    std::int64_t area() const { return std::int64_t{size.x} * size.y; }
};

int stepsOf(int texels) {
    return (texels + kPageStep - 1) / kPageStep;
}

Filled fill(std::span<const int> sides, const std::vector<std::size_t>& order, int padding, int columns, int rows) {
    Filled page;
    Skyline skyline(columns);
    for (const std::size_t image : order) {
        const auto place = skyline.place(stepsOf(sides[image] + padding), rows);
        if (!place) {
            page.left.push_back(image);
            continue;
        }
        page.places.emplace_back(image, *place * kPageStep);
        page.size = glm::max(page.size, *place * kPageStep + sides[image]);
    }
    return page;
}

/// Returns the smallest page of some widths that has all images of an order; nothing if they need several.
std::optional<Filled> fillOne(std::span<const int> sides, const std::vector<std::size_t>& order, int padding, int most) {
    double area = 0;
    for (const std::size_t image : order) area += std::pow(stepsOf(sides[image] + padding), 2);
    const int widest = stepsOf(sides[order.front()] + padding);
    std::optional<Filled> best;
    for (int i = 0; i < kPageWidths; ++i) {
        const double share = kLeastPageWidth + (kLargestPageWidth - kLeastPageWidth) * i / (kPageWidths - 1);
        const int columns = std::clamp(static_cast<int>(std::ceil(share * std::sqrt(area))), widest, most);
        Filled page = fill(sides, order, padding, columns, most);
        if (page.left.empty() && (!best || page.area() < best->area())) best = std::move(page);
    }
    return best;
}

}  // namespace

Pages packSquares(std::span<const int> sides, int padding, int largest) {
    std::vector<std::size_t> order(sides.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t image) { return sides[image]; });
    const int most = stepsOf(largest + padding);
    Pages pages;
    pages.places.resize(sides.size());
    while (!order.empty()) {
        auto page = fillOne(sides, order, padding, most);
        if (!page) page = fill(sides, order, padding, most, most);
        for (const auto& [image, first] : page->places) pages.places[image] = {pages.sizes.size(), first};
        pages.sizes.push_back(page->size);
        order = std::move(page->left);
    }
    return pages;
}

}  // namespace lightcook::atlas
