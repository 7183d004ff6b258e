// Seconds a texel of cooking each kind of asset on this machine, from the last cook. The time that a skip saved
// and that of a bake to come are estimated from them.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace lightcook::pipeline {

/// Kinds of work beside those of assets: a light map that is cooked and verified in a layout, whose name follows, and the trial of layouts.
inline constexpr const char* kLayoutWork = "layout/";
inline constexpr const char* kTrialWork = "trial";
/// File of the rates in a cache folder.
inline constexpr const char* kRatesName = "rates.json";

class WorkRates {
public:
    /// Reads the rates of earlier runs. A file that is missing or damaged counts as empty.
    explicit WorkRates(std::filesystem::path file);
    /// Notes a measured action of a kind.
    void add(const std::string& kind, double texels, double seconds);
    /// Returns the time of as many texels at the measured rate. Nothing if this machine never cooked that kind, or only assets so much
    /// smaller that what an action costs whatever its size decides their rate.
    std::optional<double> secondsOf(const std::string& kind, double texels) const;
    /// Writes the rates if there are new ones. A failure costs figures of later reports only.
    void save() const;

private:
    std::filesystem::path file_;
    struct Measured {
        double texels = 0, seconds = 0;
    };
    std::map<std::string, Measured> measured_;
    bool isChanged_ = false;
};

}  // namespace lightcook::pipeline
