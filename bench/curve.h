// Makes an HTML page that plots bits a texel against error, both logarithmic. The page is one file.
#pragma once

#include <string>
#include <vector>

namespace lightcook::bench {

struct CurvePoint {
    std::string name;
    std::string hint;              ///< shown under the pointer
    double bits = 0;               ///< bits a texel
    double first = 0, second = 0;  ///< two errors [%]; 0 is not drawn
    bool ours = false;
};
struct CurvePanel {
    std::string title;
    std::vector<CurvePoint> points;
};

/// Returns the page.
/// notes          paragraphs under the title
/// first, second  captions of CurvePoint::first, a filled mark, and CurvePoint::second, a hollow mark
std::string curvePage(const std::string& title, const std::vector<std::string>& notes, const std::string& first, const std::string& second,
                      const std::vector<CurvePanel>& panels);

}  // namespace lightcook::bench
