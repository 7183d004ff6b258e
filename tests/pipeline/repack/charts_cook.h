// Cooks of scenes whose charts are packed, in a folder of their own.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

#include "formats/light_map.h"
#include "pipeline/cook/cook.h"
#include "tests/formats/temporary_folder.h"
#include "tests/pipeline/report_parts.h"

namespace lightcook::pipeline {

class ChartsCook : public testing::Test {
protected:
    ChartsCook() {
        options_.scene = folder_ / "scene.toml";
        options_.output = folder_ / "out";
        options_.cache = LIGHTCOOK_TEST_CACHE;
    }

    /// Returns the first error of a cook, which has to fail.
    std::string mistake() const {
        const Outcome outcome = cookScene(options_, RunState());
        EXPECT_FALSE(outcome.errors.empty()) << "expected a refusal";
        return outcome.errors.empty() ? "" : outcome.errors.front().line();
    }
    /// Returns the report of an outcome, which must have no errors.
    static Json reportOf(const Outcome& outcome) {
        for (const formats::Error& error : outcome.errors) ADD_FAILURE() << error.line();
        return outcome.report;
    }
    /// Verifies the cooked folder, and returns the report.
    Json verified() const { return reportOf(verifyCooked({options_.output, {}, {}}, RunState())); }

    /// Returns the texels of a light map that reconstructLightMap() writes. They have no coverage, and may be anything outside charts.
    formats::LightMapStrip reconstructed(const std::string& map) const {
        const std::filesystem::path file = folder_ / (map + "_reconstructed.exr");
        const auto written = reconstructLightMap(options_.output, map, file, 1, RunState());
        if (!written) throw std::runtime_error(written.error().line());
        return texelsOf(file, true);
    }
    static formats::LightMapStrip texelsOf(const std::filesystem::path& file, bool repair = false) {
        formats::LightMapDescription description;
        description.repair = repair;
        auto reader = formats::LightMapReader::open(file, description);
        if (!reader) throw std::runtime_error(reader.error().line());
        auto texels = reader->read(0, reader->height());
        if (!texels) throw std::runtime_error(texels.error().line());
        return std::move(*texels);
    }

    const formats::TemporaryFolder folder_;
    CookOptions options_;
};

}  // namespace lightcook::pipeline
