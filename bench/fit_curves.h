// Collects run time against error of every fit and writes them as one CSV file and one page.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lightcook::bench {

struct FitPoint {
    std::string converter;   ///< the fit and its input: a panel of the page
    std::string series;      ///< a line of the panel, for example a kernel
    std::string way;         ///< the setting of this point, for example "4 cells"
    double cpuSeconds = 0;   ///< one thread
    double error = 0;        ///< a fraction; describe() says which. 0 is written to the CSV and not drawn
    bool isDefault = false;  ///< the default of the program
    bool isQuoted = false;   ///< another program, measured on another machine
};

class FitCurves {
public:
    /// Sets the caption of the error of a panel. Call it before adding points.
    void describe(const std::string& converter, const std::string& measure);
    void add(FitPoint point);
    /// Writes FOLDER/fits.csv and FOLDER/fits.html. Throws std::runtime_error if they cannot be written.
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
