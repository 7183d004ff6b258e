// Run time against error of every fit: collected while they are measured, left as one CSV and one page.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lightcook::bench {

struct FitPoint {
    std::string converter;  ///< what is fitted, on what: a panel of the page
    std::string series, way;
    double cpuSeconds = 0;   ///< one thread
    double error = 0;        ///< a fraction, as `measure` of the panel says; 0 is told in the CSV, and not drawn
    bool isDefault = false;  ///< what the program does unless it is asked for something else
    bool isQuoted = false;   ///< measured by somebody else, elsewhere
};

class FitCurves {
public:
    /// What a panel's error is; before its points.
    void describe(const std::string& converter, const std::string& measure);
    void add(FitPoint point);
    /// FOLDER/fits.csv and FOLDER/fits.html. Throws std::runtime_error if they cannot be written.
    void write(const std::filesystem::path& folder) const;

private:
    struct Panel {
        std::string converter, measure;
        std::vector<FitPoint> points;
    };
    Panel& panelOf(const std::string& converter);
    std::vector<Panel> panels_;
};

}  // namespace lightcook::bench
