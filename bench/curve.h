// Bits a texel against error, both logarithmic, as a page that needs nothing else.
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

/// first, second  what full and hollow marks are
std::string curvePage(const std::string& title, const std::vector<std::string>& notes, const std::string& first, const std::string& second,
                      const std::vector<CurvePanel>& panels);

}  // namespace lightcook::bench
