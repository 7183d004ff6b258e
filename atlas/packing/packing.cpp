#include "atlas/packing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <numeric>
#include <utility>

namespace lightcook::atlas {
namespace {

using Mask = formats::ImageView<const std::uint8_t>;

constexpr int kBlock = 4;
constexpr int kWordBits = 64;
/// Widths that are tried, relative to the side of a square that charts would fill.
constexpr double kWidths[] = {0.8, 0.9, 1.0, 1.04, 1.08, 1.12, 1.2, 1.3, 1.4};

int blockCeil(int texels) {
    return (texels + kBlock - 1) / kBlock * kBlock;
}

/// Texels [begin, end) of a row.
using Run = std::pair<int, int>;
/// Gaps of a row that are shorter count as read: hardly a chart would fit into them.
constexpr int kLeastGap = 4;

/// The texels that filters read of a chart, and the multiples of texels that it may begin at.
struct Shape {
    std::vector<std::vector<Run>> rows;
    int width = 0;
    std::int64_t texels = 0;  ///< that filters read
    int alignment = 1;
};

Shape shapeOf(const Mask& isRead) {
    Shape shape;
    shape.width = isRead.width;
    shape.alignment = std::min(isRead.width, isRead.height) >= kAlignedSide ? kBlock : 1;
    for (int y = 0; y < isRead.height; ++y) {
        std::vector<Run>& runs = shape.rows.emplace_back();
        for (int x = 0; x < isRead.width; ++x) {
            if (isRead.at(x, y) == 0) continue;
            if (runs.empty() || x - runs.back().second >= kLeastGap)
                runs.emplace_back(x, x + 1);
            else
                runs.back().second = x + 1;
            ++shape.texels;
        }
    }
    return shape;
}

/// One bit for each texel of a row.
class Bits {
public:
    explicit Bits(int count) : words_(static_cast<std::size_t>((count + kWordBits - 1) / kWordBits)) {}

    void set(int begin, int end) {
        for (int x = begin; x < end; ++x) words_[static_cast<std::size_t>(x / kWordBits)] |= std::uint64_t{1} << (x % kWordBits);
    }
    bool isSet(int x) const { return (words_[static_cast<std::size_t>(x / kWordBits)] >> (x % kWordBits) & 1) != 0; }
    void add(const Bits& other) {
        for (std::size_t i = 0; i < words_.size(); ++i) words_[i] |= other.words_[i];
    }
    /// Sets each bit that has a set one `distance` after it, and keeps the others.
    void addFromAfter(int distance) { merge(*this, distance); }
    /// Returns the bits, each `distance` before its place.
    Bits before(int distance) const {
        Bits moved(static_cast<int>(words_.size()) * kWordBits);
        moved.merge(*this, distance);
        return moved;
    }
    bool isEmpty() const {
        return std::all_of(words_.begin(), words_.end(), [](std::uint64_t word) { return word == 0; });
    }
    /// Returns the lowest multiple of `alignment` up to `last` whose bit is not set; nothing if there is none.
    std::optional<int> firstFree(int last, int alignment) const {
        for (int x = 0; x <= last; x += alignment) {
            if (alignment == 1 && x % kWordBits == 0 && words_[static_cast<std::size_t>(x / kWordBits)] == UINT64_MAX) {
                x += kWordBits - 1;
                continue;
            }
            if (!isSet(x)) return x;
        }
        return std::nullopt;
    }

private:
    /// Reads words from low to high and never one that it has changed, so that `from` may be this.
    void merge(const Bits& from, int distance) {
        const std::size_t words = static_cast<std::size_t>(distance / kWordBits);
        const int bits = distance % kWordBits;
        for (std::size_t i = 0; i + words < words_.size(); ++i) {
            std::uint64_t moved = from.words_[i + words] >> bits;
            if (bits > 0 && i + words + 1 < words_.size()) moved |= from.words_[i + words + 1] << (kWordBits - bits);
            words_[i] |= moved;
        }
    }

    std::vector<std::uint64_t> words_;
};

/// A page of one width that grows downwards.
class Page {
public:
    explicit Page(int width) : width_(width) {}

    glm::ivec2 place(const Shape& shape) {
        int& first = firstRow_.try_emplace({shape.rows, shape.alignment}, 0).first->second;
        for (int y = first;; y += shape.alignment) {
            const std::optional<int> x = freeColumn(shape, y);
            if (!x) continue;
            first = y;  // charts of this shape do not fit above: texels are never given back
            take(shape, *x, y);
            return {*x, y};
        }
    }
    int height() const { return static_cast<int>(rows_.size()); }

private:
    std::optional<int> freeColumn(const Shape& shape, int y) const {
        const int last = width_ - shape.width;
        Bits blocked(width_);
        for (std::size_t row = 0; row < shape.rows.size(); ++row) {
            const std::size_t at = static_cast<std::size_t>(y) + row;
            if (at >= rows_.size()) break;
            for (const auto& [begin, end] : shape.rows[row]) {
                Bits hit = rows_[at].before(begin);
                int reach = 1;
                for (; 2 * reach <= end - begin; reach *= 2) hit.addFromAfter(reach);
                if (end - begin > reach) hit.addFromAfter(end - begin - reach);
                blocked.add(hit);
            }
            if (!blocked.firstFree(last, shape.alignment)) return std::nullopt;
        }
        return blocked.firstFree(last, shape.alignment);
    }
    void take(const Shape& shape, int x, int y) {
        for (std::size_t row = 0; row < shape.rows.size(); ++row) {
            while (rows_.size() <= static_cast<std::size_t>(y) + row) rows_.emplace_back(width_);
            for (const auto& [begin, end] : shape.rows[row]) rows_[static_cast<std::size_t>(y) + row].set(x + begin, x + end);
        }
    }

    int width_;
    std::vector<Bits> rows_;
    /// Lowest row at which a shape may still fit.
    std::map<std::pair<std::vector<std::vector<Run>>, int>, int> firstRow_;
};

}  // namespace

std::optional<Packing> packCharts(std::span<const Mask> isRead, const std::atomic<bool>& interrupted) {
    std::vector<Shape> shapes;
    int widest = kBlock;
    double texels = 0;
    for (const Mask& mask : isRead) {
        shapes.push_back(shapeOf(mask));
        widest = std::max(widest, mask.width);
        texels += static_cast<double>(shapes.back().texels);
    }
    std::vector<std::size_t> order(shapes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto extent = [&](std::size_t chart) { return std::pair(shapes[chart].rows.size(), shapes[chart].width); };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return extent(a) > extent(b); });

    std::optional<Packing> best;
    const auto areaOf = [](const Packing& packing) { return static_cast<std::int64_t>(packing.size.x) * packing.size.y; };
    const auto rank = [&](const Packing& packing) { return std::pair(areaOf(packing), std::abs(packing.size.x - packing.size.y)); };
    int previous = 0;
    for (const double share : kWidths) {
        const int width = blockCeil(std::max(widest, static_cast<int>(std::ceil(share * std::sqrt(texels)))));
        if (width == std::exchange(previous, width)) continue;
        Page page(width);
        Packing packing{.places = std::vector<glm::ivec2>(shapes.size())};
        for (const std::size_t chart : order) {
            if (interrupted) return std::nullopt;
            packing.places[chart] = page.place(shapes[chart]);
        }
        packing.size = {width, std::max(blockCeil(page.height()), kBlock)};
        packing.occupancy = texels / static_cast<double>(areaOf(packing));
        if (!best || rank(packing) < rank(*best)) best = std::move(packing);
    }
    return best;
}

}  // namespace lightcook::atlas
