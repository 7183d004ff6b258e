#include "formats/mip_reduction.h"

#include <algorithm>
#include <cstddef>
#include <glm/geometric.hpp>

namespace lightcook::formats {

MipReduction::MipReduction(int width, int firstRow, int rowCount, int level)
    : width_(width),
      firstRow_(firstRow),
      rowCount_(rowCount),
      level_(level),
      texels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(rowCount)) {}

void MipReduction::add(const LightMapStrip& strip) {
    const int begin = std::max(strip.firstRow, firstRow_ << level_);
    const int end = std::min(strip.firstRow + strip.sh.height(), (firstRow_ + rowCount_) << level_);
    for (int row = begin; row < end; ++row) {
        const int y = row - strip.firstRow;
        Texel* const out = texels_.data() + static_cast<std::ptrdiff_t>((row >> level_) - firstRow_) * width_;
        for (int x = 0; x < strip.sh.width(); ++x) {
            if (strip.covered.at(x, y) == 0) continue;
            Texel& texel = out[x >> level_];
            for (std::size_t i = 0; i < texel.sh.size(); ++i) texel.sh[i] += glm::dvec3(strip.sh.at(x, y)[i]);
            texel.normal += glm::dvec3(strip.normal.at(x, y));
            if (texel.covered++ == 0) texel.firstNormal = strip.normal.at(x, y);
        }
    }
}

LightMapStrip MipReduction::finish() const {
    constexpr double kLeastNormal = 1e-3;  // of the mean: a shorter one points nowhere
    LightMapStrip strip;
    strip.firstRow = firstRow_;
    strip.sh = Image<lighting::ShRgb>(width_, rowCount_, lighting::ShRgb{});
    strip.covered = Image<std::uint8_t>(width_, rowCount_, 0);
    strip.normal = Image<glm::vec3>(width_, rowCount_, glm::vec3(0, 0, 1));
    for (int y = 0; y < rowCount_; ++y)
        for (int x = 0; x < width_; ++x) {
            const Texel& texel = texels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
            if (texel.covered == 0) continue;
            const auto count = static_cast<double>(texel.covered);
            strip.covered.at(x, y) = 1;
            for (std::size_t i = 0; i < texel.sh.size(); ++i) strip.sh.at(x, y)[i] = glm::vec3(texel.sh[i] / count);
            const double length = glm::length(texel.normal);
            strip.normal.at(x, y) = length > kLeastNormal * count ? glm::vec3(texel.normal / length) : texel.firstNormal;
        }
    return strip;
}

}  // namespace lightcook::formats
