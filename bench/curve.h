// Writes a page that plots bits a texel against error, both logarithmic. The page is one file.
#pragma once

#include <string>
#include <vector>

namespace lightcook::bench {

struct CurvePoint {
    std::string name;
    std::string hint;              ///< shown when pointed at
    double bits = 0;               ///< a texel
    double first = 0, second = 0;  ///< percent; 0 is not drawn
    bool ours = false;
};
struct CurvePanel {
    std::string title;
    std::vector<CurvePoint> points;
};

/// first, second  captions of the full and the hollow marks
std::string curvePage(const std::string& title, const std::vector<std::string>& notes, const std::string& first, const std::string& second,
                      const std::vector<CurvePanel>& panels);

}  // namespace lightcook::bench
