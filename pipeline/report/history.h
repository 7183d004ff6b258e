// The history of scenes: a file of JSON lines, one for each report of a scene.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

struct Report;

struct HistoryLine {
    std::string lightcook;  ///< version of the program
    std::string at;         ///< start of the last run that made the results, UTC
    std::string scene, target;
    bool passed = false;
    std::uint64_t bytesGpu = 0;
    std::map<std::string, std::uint64_t> byKind;
    std::optional<double> diffuse, specular;  ///< largest rel_rms of an asset; none of light that no asset has
    std::optional<double> visible;            ///< largest 99th percentile of visible errors of an asset
};
template <class Fields, Is<HistoryLine> Self>
void describe(Fields& fields, Self& line) {
    fields.required("lightcook", line.lightcook, "version of the program");
    fields.required("at", line.at, "start of the last run that made the results, UTC");
    fields.required("scene", line.scene, "name of the scene");
    fields.required("target", line.target, "target of the cook");
    fields.required("passed", line.passed, "verdict of the report");
    fields.required("bytes_gpu", line.bytesGpu, "GPU memory of all assets [bytes]");
    fields.required("by_kind", line.byKind, "GPU memory by kind of asset [bytes]");
    fields.nullable("diffuse_rel_rms", line.diffuse, between(0, HUGE_VAL),
                    "largest rel_rms of diffuse light of an asset; null where none has it");
    fields.nullable("specular_rel_rms", line.specular, between(0, HUGE_VAL),
                    "largest rel_rms of specular light of an asset; null where none has it");
    fields.optional("visible_p99", line.visible, kFigure, "largest 99th percentile of the visible errors of an asset");
}

/// Returns the line of a report.
HistoryLine historyLine(const Report& report, std::string target);

/// Reads a history, oldest line first. A missing file has no lines. A line of another shape is refused by its number.
formats::Result<std::vector<HistoryLine>> readHistory(const std::filesystem::path& file);

/// Appends the lines in one write, and returns the whole history. A line that equals the last one of its scene and target is left out, so
/// that a report that is made twice counts once. Programs that append at the same time wait for each other.
formats::Result<std::vector<HistoryLine>> appendHistory(const std::filesystem::path& file, const std::vector<HistoryLine>& lines);

}  // namespace lightcook::pipeline
