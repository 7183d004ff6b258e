// Runs of the program that made results: a result from the cache keeps the time and the memory of the run that made it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

struct RunRecord {
    std::string at;  ///< start, UTC: "2026-11-22T13:53:01.123Z"; names the run
    double seconds = 0;
    std::uint64_t peakRssBytes = 0;
    int actions = 0;                      ///< that it ran
    double workSeconds = 0;               ///< of the actions whose results it used first, one after the other
    std::vector<std::string> walls = {};  ///< formats::wallsOfReaders()

    /// Returns the run with the part of its time that some of these actions took.
    /// used  time of these, one after the other
    RunRecord partOf(double used) const {
        RunRecord part = *this;
        if (workSeconds > 0) part.seconds *= std::min(1.0, used / workSeconds);
        return part;
    }
};
template <class Fields, Is<RunRecord> Self>
void describe(Fields& fields, Self& run) {
    fields.required("at", run.at, "start of the run, UTC, by which rows name it");
    fields.required("seconds", run.seconds, between(0, HUGE_VAL), "wall time; in a report the part of it that made what the report has");
    fields.required("peak_rss_bytes", run.peakRssBytes, "most memory that was resident");
    fields.required("actions", run.actions, "actions that it ran; others came from the cache");
    fields.presentIf(
        !run.walls.empty(), "walls", run.walls,
        "what stood between the program and the decoders of OpenEXR, OpenImageIO and Draco: `process`, `limits`, `privileges`, "
        "`landlock`, `seccomp`; `none`: --no-sandbox");
    fields.presentIf(true, "work_seconds", run.workSeconds, "time of these actions, one after the other");
}

/// Returns the time of day as RunRecord::at has it.
std::string timeNow();

}  // namespace lightcook::pipeline
