// Charts of a light map, found row by row: connected covered texels (8 neighbours), which of them are black, and fireflies at their rims.
//
// Connected components by union-find on the runs of covered texels of two neighbouring rows; charts that the new row does not continue are
// counted and dropped, so memory grows with the width of the map alone. Rows must come in order.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

/// A covered texel at the rim of a chart that is brighter than its covered neighbours.
struct RimFirefly {
    int x = 0, y = 0;
    double light = 0, brightest = 0;  ///< of the texel and of its brightest covered neighbour
};
template <class Fields, Is<RimFirefly> Self>
void describe(Fields& fields, Self& firefly) {
    fields.required("x", firefly.x, "texel");
    fields.required("y", firefly.y, "texel");
    fields.required("light", firefly.light, "largest channel of sh00");
    fields.required("brightest", firefly.brightest, "that of the brightest covered neighbour");
}

struct ChartFacts {
    std::int64_t charts = 0, blackCharts = 0, blackTexels = 0;
    std::int64_t rimFireflies = 0;
    RimFirefly worst;          ///< the brightest of them
    double worstRimRatio = 0;  ///< largest ratio of a bright rim texel to its brightest neighbour that is not black
};
template <class Fields, Is<ChartFacts> Self>
void describe(Fields& fields, Self& facts) {
    fields.required("charts", facts.charts, "connected groups of covered texels");
    fields.required("black_charts", facts.blackCharts, "charts without any light");
    fields.required("black_texels", facts.blackTexels, "texels of these charts");
    fields.required("rim_fireflies", facts.rimFireflies, "fireflies at the rims of charts");
    fields.required("worst", facts.worst, "the brightest of them");
    fields.required("worst_rim_ratio", facts.worstRimRatio, "largest ratio of a bright texel at a rim to its brightest neighbour");
}

/// Rows of a light map, as far as the scanner reads them.
class ChartRows {
public:
    /// light  the largest channel of sh00 of each texel of the next row; negative where it is not covered
    void addRow(std::vector<float> light);

    template <class Archive, class Self>
    static void members(Archive& archive, Self& self) {
        archive(self.runs_, self.first_, self.last_, self.candidates_);
        archive.sparse(self.histogram_);
    }

private:
    friend class ChartScanner;
    /// Covered texels [first, end) of a row, all of which touch.
    struct Run {
        int first = 0, end = 0;
        bool isLit = false;
    };
    std::vector<std::vector<Run>> runs_;     ///< [row]
    std::vector<std::vector<float>> first_;  ///< light of the first two rows, as far as there are so many
    std::vector<std::vector<float>> last_;   ///< and of the last two
    std::vector<RimFirefly> candidates_;     ///< bright against their neighbours: of all rows but the first and the last
    std::vector<std::int64_t> histogram_;    ///< of light, four bins an octave; empty without rows
};

class ChartScanner {
public:
    /// fireflyLimit  largest ratio of a texel to its brightest neighbour; 0: no test
    ChartScanner(int width, double fireflyLimit);
    void add(const ChartRows& rows);
    ChartFacts finish();

private:
    struct Chart {
        std::int64_t texels = 0;
        bool isLit = false;
    };
    std::size_t root(std::size_t label);
    void join(std::size_t a, std::size_t b);
    void label(const std::vector<ChartRows::Run>& runs);
    void close(const Chart& chart);
    void lookAbove(const std::vector<float>& light);
    double firefliesFrom() const;

    double limit_;
    int rows_ = 0;
    std::vector<float> above_, row_;  ///< the two rows before the one that is added
    std::vector<ChartRows::Run> runs_;
    std::vector<std::size_t> labels_;  ///< of the runs of the row before
    std::vector<std::size_t> parents_;
    std::vector<Chart> open_;
    std::vector<std::int64_t> histogram_;
    std::vector<RimFirefly> candidates_;  ///< bright against their neighbours, maybe not against the map
    ChartFacts facts_;
};

}  // namespace lightcook::pipeline
