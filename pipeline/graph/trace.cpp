#include "pipeline/graph/trace.h"

namespace lightcook::pipeline {

void Trace::add(const std::string& name, const char* category, Clock::time_point start, const Json& arguments) {
    const auto microseconds = [](Clock::duration time) { return std::chrono::duration<double, std::micro>(time).count(); };
    const Clock::time_point end = Clock::now();
    const std::lock_guard lock(mutex_);
    const int thread = threads_.try_emplace(std::this_thread::get_id(), static_cast<int>(threads_.size()) + 1).first->second;
    events_.push_back({{"name", name},
                       {"cat", category},
                       {"ph", "X"},
                       {"ts", microseconds(start - start_)},
                       {"dur", microseconds(end - start)},
                       {"pid", 1},
                       {"tid", thread},
                       {"args", arguments}});
}

Json Trace::document() const {
    const std::lock_guard lock(mutex_);
    return {{"traceEvents", events_}, {"displayTimeUnit", "ms"}};
}

}  // namespace lightcook::pipeline
