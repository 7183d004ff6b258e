// The texels of a light map with the largest visible errors.
#pragma once

#include <vector>

namespace lightcook::pipeline {

struct WorstTexel {
    int x = 0, y = 0;
    float visible = -1;  ///< negative: no texel
};

/// The texel with the largest visible error of each square of 16 x 16, as far as it may be among the worst of the map.
class WorstTexels {
public:
    static constexpr int kSquare = 16;

    WorstTexels() = default;
    /// Constructs squares for rows [firstRow, firstRow + rowCount), which begin with a row of squares.
    WorstTexels(int width, int firstRow, int rowCount)
        : firstRow_(firstRow),
          across_((width + kSquare - 1) / kSquare),
          texels_(static_cast<std::size_t>(across_) * static_cast<std::size_t>((rowCount + kSquare - 1) / kSquare)) {}
    void add(int x, int y, float visible) {
        const WorstTexel texel{x, y, visible};
        WorstTexel& worst = texels_[static_cast<std::size_t>((y - firstRow_) / kSquare * across_ + x / kSquare)];
        if (isWorse(texel, worst)) worst = texel;
    }
    /// Merges other rows, in any order. Only for objects made without squares.
    void merge(const WorstTexels& other);
    /// Returns at most `count` merged texels, the worst first, each further than `distance` from those before it in x or y.
    std::vector<WorstTexel> apart(std::size_t count, int distance) const;

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.firstRow_, self.across_, self.texels_);
    }

private:
    static constexpr std::size_t kKept = 256;  ///< enough for a few places, each with all squares around it
    static bool isWorse(const WorstTexel& a, const WorstTexel& b) {
        if (a.visible != b.visible) return a.visible > b.visible;
        return a.y != b.y ? a.y < b.y : a.x < b.x;
    }

    int firstRow_ = 0, across_ = 0;
    std::vector<WorstTexel> texels_;  ///< [square], or those that were merged
};

}  // namespace lightcook::pipeline
