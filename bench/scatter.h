// Makes an HTML page of scatter plots of run time against quality or error, with a panel for each format or fit. The page is one file.
#pragma once

#include <string>
#include <vector>

namespace lightcook::bench {

struct ScatterPoint {
    double secondsPerMpix = 0, db = 0;  ///< in a panel of errors: seconds, and log10 of the error
    std::string label;                  ///< beside the point; may be empty
    std::string hint;                   ///< shown under the pointer
};

struct ScatterSeries {
    enum class Style {
        Main,            ///< a line with filled points and labels
        Part,            ///< a thin line with small points
        Peer,            ///< a line with filled diamonds and labels: another encoder, run here
        Front,           ///< rings around points, joined by a stepped line
        Quoted,          ///< hollow diamonds, no line: figures that somebody else measured on the same pictures
        QuotedElsewhere  ///< hollow squares: measured on other pictures
    };
    std::string name;
    Style style = Style::Main;
    std::vector<ScatterPoint> points;
};

struct ScatterPanel {
    std::string title, yLabel;
    std::vector<ScatterSeries> series;
    std::string xLabel = "time for a megapixel, one thread (left is faster)";
    bool isError = false;  ///< the vertical axis shows powers of ten of an error instead of decibels
};

/// Returns the page.
/// notes  paragraphs of text under the title
std::string scatterPage(const std::string& title, const std::vector<std::string>& notes, const std::vector<ScatterPanel>& panels);

}  // namespace lightcook::bench
