// What a run did and when, as trace events of Chrome: https://ui.perfetto.dev and chrome://tracing draw them.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "pipeline/document/json.h"

namespace lightcook::pipeline {

/// Collects spans. May be used from several threads.
class Trace {
public:
    using Clock = std::chrono::steady_clock;

    /// Adds a span of the calling thread that ends now.
    /// category   "action", "wait", "remote read" or "remote write"
    void add(const std::string& name, const char* category, Clock::time_point start, const Json& arguments);
    /// Returns the document: an object with "traceEvents".
    Json document() const;

private:
    const Clock::time_point start_ = Clock::now();
    mutable std::mutex mutex_;
    std::map<std::thread::id, int> threads_;  ///< numbered as they come
    Json events_ = Json::array();
};

}  // namespace lightcook::pipeline
