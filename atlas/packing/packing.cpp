// Search for a small page.
//
// One trial places the charts of a page of given width in a given order, each to the lowest row, then column, where it fits (bottom left;
// Jakobs, On genetic algorithms for the packing of polygons, 1996), and is given up as soon as a chart ends beyond the height at which the
// page would be no smaller than the best one. First come all widths from kLeastWidth to kLargestWidth, the squarest page first, with the
// charts sorted by each of kOrders. Then the best order is changed at random, by one or two moves or exchanges of charts and sometimes
// another width, and the change is kept unless the page grows. Of pages of equal size the one with fewer texels in its last row of blocks
// is better: it is nearer to a row less. The search ends after kChanges changes or kLargestWork steps of work, whichever comes first, so
// that its result depends neither on the clock nor on the machine.
#include "atlas/packing.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <utility>

namespace lightcook::atlas {
namespace {

using Mask = formats::ImageView<const std::uint8_t>;

constexpr int kBlock = 4;
constexpr int kWordBits = 64;
/// Widths that are tried, relative to the side of a square that charts would fill.
constexpr double kLeastWidth = 0.7, kLargestWidth = 1.4;
/// Changes of the best order.
constexpr int kChanges = 1000;
/// Words of rows that the search looks at: about half a second.
constexpr std::int64_t kLargestWork = 100'000'000;

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
    std::size_t kind = 0;  ///< the same for equal shapes

    int height() const { return static_cast<int>(rows.size()); }
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

    void clear() { std::ranges::fill(words_, 0); }
    void set(int begin, int end) {
        for (int x = begin; x < end;) {
            const int bit = x % kWordBits, count = std::min(end - x, kWordBits - bit);
            words_[static_cast<std::size_t>(x / kWordBits)] |= UINT64_MAX >> (kWordBits - count) << bit;
            x += count;
        }
    }
    int count() const {
        return std::accumulate(words_.begin(), words_.end(), 0, [](int sum, std::uint64_t word) { return sum + std::popcount(word); });
    }
    std::int64_t words() const { return static_cast<std::int64_t>(words_.size()); }
    void add(const Bits& other) {
        for (std::size_t i = 0; i < words_.size(); ++i) words_[i] |= other.words_[i];
    }
    /// Sets each bit that has a set one in `other`, `distance` after it, and keeps the others. `other` may be this: words are read from low
    /// to high, and never one that was changed.
    void addFromAfter(const Bits& other, int distance) {
        const std::size_t words = static_cast<std::size_t>(distance / kWordBits);
        const int bits = distance % kWordBits;
        for (std::size_t i = 0; i + words < words_.size(); ++i) {
            std::uint64_t moved = other.words_[i + words] >> bits;
            if (bits > 0 && i + words + 1 < words_.size()) moved |= other.words_[i + words + 1] << (kWordBits - bits);
            words_[i] |= moved;
        }
    }
    /// Returns the lowest multiple of `alignment` (1 or kBlock) up to `last` whose bit is not set; nothing if there is none.
    std::optional<int> firstFree(int last, int alignment) const {
        const std::uint64_t aligned = alignment == 1 ? UINT64_MAX : UINT64_MAX / ((1 << kBlock) - 1);
        for (int x = 0; x <= last; x += kWordBits) {
            const std::uint64_t free = ~words_[static_cast<std::size_t>(x / kWordBits)] & aligned;
            if (free == 0) continue;
            x += std::countr_zero(free);
            return x <= last ? std::optional(x) : std::nullopt;
        }
        return std::nullopt;
    }

private:
    std::vector<std::uint64_t> words_;
};

/// A page of one width that grows downwards.
class Page {
public:
    /// kinds  of shapes
    Page(int width, std::size_t kinds) : width_(width), blocked_(width), hit_(width), firstRow_(kinds, 0) {}

    /// Returns the place of a shape; nothing if it fits into no rows before `end`.
    std::optional<glm::ivec2> place(const Shape& shape, int end) {
        int& first = firstRow_[shape.kind];
        for (int y = first; y + shape.height() <= end; y += shape.alignment) {
            const std::optional<int> x = freeColumn(shape, y);
            if (!x) continue;
            first = y;  // charts of this shape do not fit above: texels are never given back
            take(shape, *x, y);
            return glm::ivec2(*x, y);
        }
        return std::nullopt;
    }
    int height() const { return std::max(blockCeil(static_cast<int>(rows_.size())), kBlock); }
    /// Returns the number of texels in the last row of blocks.
    int lastTexels() const {
        int texels = 0;
        for (std::size_t y = static_cast<std::size_t>(height() - kBlock); y < rows_.size(); ++y) texels += rows_[y].count();
        return texels;
    }
    /// Returns the number of words that place() has looked at.
    std::int64_t work() const { return work_; }

private:
    std::optional<int> freeColumn(const Shape& shape, int y) {
        const int last = width_ - shape.width;
        blocked_.clear();
        for (std::size_t row = 0; row < shape.rows.size(); ++row) {
            const std::size_t at = static_cast<std::size_t>(y) + row;
            if (at >= rows_.size()) break;
            for (const auto& [begin, end] : shape.rows[row]) {
                hit_.clear();
                hit_.addFromAfter(rows_[at], begin);
                int reach = 1;
                for (; 2 * reach <= end - begin; reach *= 2) hit_.addFromAfter(hit_, reach);
                if (end - begin > reach) hit_.addFromAfter(hit_, end - begin - reach);
                blocked_.add(hit_);
                work_ += hit_.words();
            }
            if (!blocked_.firstFree(last, shape.alignment)) return std::nullopt;
        }
        return blocked_.firstFree(last, shape.alignment);
    }
    void take(const Shape& shape, int x, int y) {
        for (std::size_t row = 0; row < shape.rows.size(); ++row) {
            while (rows_.size() <= static_cast<std::size_t>(y) + row) rows_.emplace_back(width_);
            for (const auto& [begin, end] : shape.rows[row]) rows_[static_cast<std::size_t>(y) + row].set(x + begin, x + end);
        }
    }

    int width_;
    std::vector<Bits> rows_;
    Bits blocked_, hit_;         ///< of freeColumn()
    std::vector<int> firstRow_;  ///< lowest row at which each kind of shape may still fit
    std::int64_t work_ = 0;
};

/// Charts are sorted by the first number, the largest first, and equal ones by the second.
using Extent = std::pair<std::int64_t, std::int64_t>;
constexpr std::array<Extent (*)(const Shape&), 5> kOrders = {
    [](const Shape& shape) { return Extent(shape.height(), shape.width); },
    [](const Shape& shape) { return Extent(std::max(shape.height(), shape.width), std::min(shape.height(), shape.width)); },
    [](const Shape& shape) { return Extent(shape.width, shape.height()); },
    [](const Shape& shape) { return Extent(shape.texels, shape.height()); },
    [](const Shape& shape) { return Extent(shape.width + shape.height(), shape.height()); },
};

using Order = std::vector<std::size_t>;

/// The smallest page that was found.
class Search {
public:
    Search(std::span<const Mask> isRead, const std::atomic<bool>& interrupted) : interrupted_(interrupted) {
        std::map<std::pair<std::vector<std::vector<Run>>, int>, std::size_t> kinds;
        for (const Mask& mask : isRead) {
            Shape& shape = shapes_.emplace_back(shapeOf(mask));
            shape.kind = kinds.try_emplace({shape.rows, shape.alignment}, kinds.size()).first->second;
            widest_ = std::max(widest_, mask.width);
            texels_ += static_cast<double>(shape.texels);
        }
        kinds_ = kinds.size();
    }

    std::optional<Packing> run() {
        const std::vector<int> widths = widthsToTry();
        for (const auto& extent : kOrders) {
            const Order order = sortedBy(extent);
            for (const int width : widths)
                if (mayGoOn()) attempt(order, width);
        }
        std::mt19937 random;  // of a fixed seed
        const auto below = [&](std::size_t end) { return static_cast<std::size_t>(random()) % end; };
        for (int i = 0; i < kChanges && shapes_.size() > 1 && mayGoOn(); ++i) {
            Order order = order_;
            for (std::size_t changes = 1 + below(2); changes > 0; --changes) {
                const std::size_t from = below(order.size()), to = below(order.size());
                if (below(3) == 0)
                    std::swap(order[from], order[to]);
                else
                    move(order, from, to);
            }
            const int width = below(4) == 0 ? widths[below(widths.size())] : best_.size.x;
            attempt(order, width);
        }
        if (interrupted_) return std::nullopt;
        return std::move(best_);
    }

private:
    bool mayGoOn() const { return !interrupted_ && (best_.size.x == 0 || work_ < kLargestWork); }

    /// Returns the widths, the squarest page first.
    std::vector<int> widthsToTry() const {
        const double side = std::sqrt(texels_);
        const auto atLeast = [&](double share) { return blockCeil(std::max(widest_, static_cast<int>(std::ceil(share * side)))); };
        std::vector<int> widths;
        for (int width = atLeast(kLeastWidth); width <= atLeast(kLargestWidth); width += kBlock) widths.push_back(width);
        std::ranges::stable_sort(widths, {}, [&](int width) { return std::abs(width - atLeast(1)); });
        return widths;
    }
    Order sortedBy(Extent (*extent)(const Shape&)) const {
        Order order(shapes_.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t chart) { return extent(shapes_[chart]); });
        return order;
    }
    static void move(Order& order, std::size_t from, std::size_t to) {
        const auto begin = order.begin(), source = begin + static_cast<std::ptrdiff_t>(from),
                   target = begin + static_cast<std::ptrdiff_t>(to);
        if (source < target)
            std::rotate(source, source + 1, target + 1);
        else
            std::rotate(target, source, source + 1);
    }
    /// Keeps the packing in an order if it is not worse than the best one.
    void attempt(const Order& order, int width) {
        Page page(width, kinds_);
        const std::int64_t rows = bestArea_ / width;
        const int end = static_cast<int>(std::min<std::int64_t>(rows / kBlock * kBlock, std::numeric_limits<int>::max()));
        std::vector<glm::ivec2> places(shapes_.size());
        bool isWhole = true;
        for (std::size_t i = 0; i < order.size() && isWhole && !interrupted_; ++i) {
            const auto place = page.place(shapes_[order[i]], end);
            isWhole = place.has_value();
            if (place) places[order[i]] = *place;
        }
        work_ += page.work();
        if (!isWhole || interrupted_) return;
        const std::int64_t area = static_cast<std::int64_t>(width) * page.height();
        const double last = static_cast<double>(page.lastTexels()) / width;
        if (std::pair(area, last) > std::pair(bestArea_, bestLast_)) return;
        bestArea_ = area;
        bestLast_ = last;
        order_ = order;
        best_ = {{width, page.height()}, std::move(places), texels_ / static_cast<double>(area)};
    }

    const std::atomic<bool>& interrupted_;
    std::vector<Shape> shapes_;
    std::size_t kinds_ = 0;
    int widest_ = kBlock;
    double texels_ = 0;

    Packing best_;
    Order order_;  ///< of the best packing
    std::int64_t bestArea_ = std::numeric_limits<std::int64_t>::max();
    double bestLast_ = 0;  ///< texels in the last row of blocks, of each column
    std::int64_t work_ = 0;
};

}  // namespace

std::optional<Packing> packCharts(std::span<const Mask> isRead, const std::atomic<bool>& interrupted) {
    return Search(isRead, interrupted).run();
}

}  // namespace lightcook::atlas
