// Images in memory: an owner that moves, and views that are passed to functions.
// Row 0 is the top row, x runs to the right; texel (x, y) has its centre at ((x + 0.5) / width, (y + 0.5) / height).
#pragma once

#include <cassert>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace lightcook::formats {

/// Texels owned by somebody else. Row y starts at texels + y * rowStride.
template <class T>
struct ImageView {
    T* texels = nullptr;
    int width = 0, height = 0;     ///< [texels]
    std::ptrdiff_t rowStride = 0;  ///< [texels], >= width

    T& at(int x, int y) const {
        assert(0 <= x && x < width && 0 <= y && y < height);
        return texels[y * rowStride + x];
    }
    T* row(int y) const { return texels + y * rowStride; }

    /// Returns the rows [firstRow, firstRow + rowCount) of this view.
    ImageView rows(int firstRow, int rowCount) const {
        assert(0 <= firstRow && 0 <= rowCount && firstRow + rowCount <= height);
        return {texels + firstRow * rowStride, width, rowCount, rowStride};
    }
    operator ImageView<const T>() const requires(!std::is_const_v<T>) { return {texels, width, height, rowStride}; }
};

/// Owns width * height texels, rows packed. Moves; copy() makes a copy.
template <class T>
class Image {
public:
    Image() = default;
    Image(int width, int height, T fill = T{})
        : width_(width), height_(height), texels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill) {}
    Image(Image&&) noexcept = default;
    Image& operator=(Image&&) noexcept = default;
    Image copy() const { return Image(*this); }

    int width() const { return width_; }
    int height() const { return height_; }
    T& at(int x, int y) { return view().at(x, y); }
    const T& at(int x, int y) const { return view().at(x, y); }
    ImageView<T> view() { return {texels_.data(), width_, height_, width_}; }
    ImageView<const T> view() const { return {texels_.data(), width_, height_, width_}; }
    std::vector<T>& texels() { return texels_; }
    const std::vector<T>& texels() const { return texels_; }

private:
    Image(const Image&) = default;
    Image& operator=(const Image&) = default;

    int width_ = 0, height_ = 0;
    std::vector<T> texels_;
};

}  // namespace lightcook::formats
