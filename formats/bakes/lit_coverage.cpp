#include "formats/bakes/lit_coverage.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace lightcook::formats {
namespace {

/// Removes all rows of an image but [firstRow, firstRow + rowCount). An empty image stays empty.
template <class T>
void keepRows(Image<T>& image, int firstRow, int rowCount) {
    if (image.width() == 0) return;
    Image<T> kept(image.width(), rowCount);
    const ImageView<T> rows = image.view().rows(firstRow, rowCount);
    std::copy_n(rows.texels, kept.texels().size(), kept.texels().begin());
    image = std::move(kept);
}

class CoveredByLight final : public BakeReader {
public:
    explicit CoveredByLight(std::unique_ptr<BakeReader> bake) : bake_(std::move(bake)) {}
    int width() const override { return bake_->width(); }
    int height() const override { return bake_->height(); }
    int tileHeight() const override { return bake_->tileHeight(); }
    std::optional<int> sliceCount() const override { return bake_->sliceCount(); }
    bool hasNormals() const override { return bake_->hasNormals(); }
    bool hasCoverage() const override { return true; }
    std::optional<StoredNumber> placeOf(std::size_t coefficient, int colour, int x, int y) const override {
        return bake_->placeOf(coefficient, colour, x, y);
    }

    Result<std::string> storedDigest(int firstRow, int rowCount) const override {
        const int first = std::max(firstRow - kReach, 0), end = std::min(firstRow + rowCount + kReach, height());
        return bake_->storedDigest(first, end - first);
    }
    Result<RawStrip> read(int firstRow, int rowCount) const override {
        const int first = std::max(firstRow - kReach, 0), end = std::min(firstRow + rowCount + kReach, height()), above = firstRow - first;
        Result<RawStrip> raw = bake_->read(first, end - first);
        if (!raw) return raw;
        Image<std::uint8_t> lit(width(), end - first);
        for (int y = 0; y < lit.height(); ++y)
            for (int x = 0; x < width(); ++x) lit.at(x, y) = raw->sh.at(x, y)[0] != glm::vec3(0) ? 1 : 0;
        Image<float> coverage(width(), rowCount, 0);
        for (int y = 0; y < rowCount; ++y)
            for (int x = 0; x < width(); ++x)
                if (lit.at(x, y + above) != 0 || isBetween(lit, x, y + above)) coverage.at(x, y) = 1;
        keepRows(raw->sh, above, rowCount);
        keepRows(raw->normal, above, rowCount);
        keepRows(raw->tangent, above, rowCount);
        keepRows(raw->chart, above, rowCount);
        keepRows(raw->negative, above, rowCount);
        raw->coverage = std::move(coverage);
        return raw;
    }

private:
    static constexpr int kReach = 2;  ///< [texels]

    /// Returns true if lit texels lie on two opposite sides of a texel.
    static bool isBetween(const Image<std::uint8_t>& lit, int x, int y) {
        const auto isLitTowards = [&](int right, int down) {
            for (int step = 1; step <= kReach; ++step) {
                const int column = x + step * right, row = y + step * down;
                if (column < 0 || column >= lit.width() || row < 0 || row >= lit.height()) return false;
                if (lit.at(column, row) != 0) return true;
            }
            return false;
        };
        return (isLitTowards(-1, 0) && isLitTowards(1, 0)) || (isLitTowards(0, -1) && isLitTowards(0, 1)) ||
               (isLitTowards(-1, -1) && isLitTowards(1, 1)) || (isLitTowards(-1, 1) && isLitTowards(1, -1));
    }

    std::unique_ptr<BakeReader> bake_;
};

}  // namespace

std::unique_ptr<BakeReader> coveredByLight(std::unique_ptr<BakeReader> bake) {
    return std::make_unique<CoveredByLight>(std::move(bake));
}

}  // namespace lightcook::formats
