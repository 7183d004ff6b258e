#include "pipeline/command/terminal/progress.h"

#include "pipeline/assets/action_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>

namespace lightcook::pipeline {
namespace {

constexpr int kBarWidth = 24;
/// Time left is shown from here on: earlier estimates jump.
constexpr double kLeastSeconds = 2, kLeastFraction = 0.2;
/// An estimate of the end replaces the one that is shown if the time left differs by more than this ratio: it is no better below.
constexpr double kSteadyRatio = 1.25;

/// Time of an action, as measured on the public scenes with one thread.
struct WorkRate {
    std::string_view kind;
    double secondsPerMegabyte;  ///< of its inputs
};
constexpr double kLeastWork = 0.02, kOtherRate = 0.01;
constexpr std::array kWorkRates = {
    WorkRate{kLightMapTrialKind, 0.3}, WorkRate{kJointTrialKind, 0.5},  WorkRate{"light-map", 0.04},
    WorkRate{"verify-light-map", 0.2}, WorkRate{"dominant", 0.025},     WorkRate{"verify-dominant", 0.05},
    WorkRate{"cubemap", 0.1},          WorkRate{"verify-cubemap", 1.2}, WorkRate{"mesh", 0.01},
    WorkRate{"verify-mesh", 0.02},     WorkRate{kPackChartsKind, 0.3},
};

/// Returns true if a cook runs actions of this kind before it has its plan, or lint its findings.
bool isPreparation(std::string_view kind) {
    constexpr std::array kKinds = {kMaterialsKind, kContentKind, kFloorKind, kProbeUseKind};
    return kind.starts_with("lint-") || std::ranges::find(kKinds, kind) != kKinds.end();
}

/// Returns "0:14", "12:05" or "1:02:10".
std::string clockWords(double seconds) {
    const long long whole = std::llround(seconds);
    if (whole >= 3600) return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

std::string bar(double fraction) {
    const auto filled = static_cast<std::size_t>(std::clamp(fraction, 0.0, 1.0) * kBarWidth);
    return fmt::format("[{}{}]", std::string(filled, '#'), std::string(kBarWidth - filled, '.'));
}

/// Returns the text cut to a number of characters; file names may have more bytes than characters.
std::string cut(const std::string& text, int columns) {
    std::string shown;
    int count = 0;
    for (const char c : text) {
        if ((static_cast<unsigned char>(c) & 0xC0u) != 0x80u && ++count > columns) break;
        shown += c;
    }
    return shown;
}

}  // namespace

double workOf(const Action& action) {
    double megabytes = 0;
    for (const auto& [role, path] : action.inputs) {
        std::error_code code;
        const std::uintmax_t bytes = std::filesystem::file_size(path, code);
        if (!code) megabytes += static_cast<double>(bytes) * 1e-6;
    }
    const auto rate = std::ranges::find(kWorkRates, action.kind, &WorkRate::kind);
    return kLeastWork + megabytes * (rate == kWorkRates.end() ? kOtherRate : rate->secondsPerMegabyte);
}

void Progress::onEvent(const Action& action, ActionEvent event) {
    const std::lock_guard lock(mutex_);
    isPlanned_ = isPlanned_ || !isPreparation(action.kind);
    switch (event) {
        case ActionEvent::Planned:
            weights_.emplace(action.id, workOf(action));
            break;
        case ActionEvent::Started:
            running_[action.id] = {action.id, 0};
            repeatLocked(action.id);
            break;
        case ActionEvent::Finished:
        case ActionEvent::Reused:
        case ActionEvent::Failed:
            running_.erase(action.id);
            done_.insert(action.id);
            break;
    }
}

void Progress::repeatLocked(const std::string& id) {
    if (done_.erase(id) == 0) return;
    repeatedWork_ += weights_.at(id);
    ++repeated_;
    if (!isOfStep(id, ActionStep::Cook)) return;
    for (const ActionStep step : {ActionStep::Verify, ActionStep::Whole}) repeatLocked(actionId(step, actionSubject(id, ActionStep::Cook)));
}

void Progress::onPass(const Action& action, const std::string& what, double fraction) {
    const std::lock_guard lock(mutex_);
    isPlanned_ = isPlanned_ || !isPreparation(action.kind);
    weights_.emplace(action.id, workOf(action));
    Running& running = running_[action.id];
    running.what = what;
    // Later passes of an action start at 0 again.
    running.fraction = std::max(running.fraction, fraction);
}

double Progress::fractionLocked() const {
    double all = repeatedWork_, done = repeatedWork_;
    for (const auto& [id, weight] : weights_) {
        all += weight;
        const auto running = running_.find(id);
        if (done_.contains(id))
            done += weight;
        else if (running != running_.end())
            done += weight * running->second.fraction;
    }
    return all > 0 ? done / all : 0;
}

double Progress::fraction() const {
    const std::lock_guard lock(mutex_);
    return fractionLocked();
}

std::string Progress::leftLocked(double seconds, double fraction) {
    if (seconds < kLeastSeconds || fraction < kLeastFraction || fraction >= 1) return "";
    const double left = seconds * (1 - fraction) / fraction, shown = end_ - seconds;
    if (shown <= 0 || left > kSteadyRatio * shown || shown > kSteadyRatio * left) end_ = seconds + left;
    return fmt::format("  {} left", clockWords(end_ - seconds));
}

std::string Progress::line(double seconds, int columns) {
    const std::lock_guard lock(mutex_);
    const double fraction = fractionLocked();
    std::string stages;
    for (const auto& [id, running] : running_)
        stages += fmt::format("{}{} {:.0f} %", stages.empty() ? "" : ", ", formats::withoutControls(running.what), 100 * running.fraction);
    if (!isPlanned_) return cut(stages, columns - 1);
    const std::string head =
        fmt::format("{} {:3.0f} %  {}/{} ", bar(fraction), 100 * fraction, done_.size() + repeated_, weights_.size() + repeated_);
    const std::string tail = leftLocked(seconds, fraction);
    // The last column stays free: some terminals wrap there.
    const int room = columns - 1 - static_cast<int>(head.size() + tail.size());
    return cut(head + cut(stages, std::max(room, 0)) + tail, columns - 1);
}

}  // namespace lightcook::pipeline
