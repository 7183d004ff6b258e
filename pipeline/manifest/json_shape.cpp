#include "pipeline/manifest/json_shape.h"

#include <cmath>

#include "pipeline/assets/results.h"
#include "pipeline/json/json_fields.h"
#include "pipeline/manifest/cooked_asset.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {
namespace {

// The structs below list the members of report.json for the check of its shape and for the reference. Members of type Json are shown, but
// nothing depends on their shape: the page tolerates an edited report.

constexpr FieldRule kNotNegative = between(0, HUGE_VAL), kBytes = between(0, kLargestBytes);

struct FiguresShape {
    double relRms = 0, p99 = 0, maxSampled = 0, maxBound = 0;
    std::optional<Json> sampledAt, boundAt;
};
template <class Fields, Is<FiguresShape> Self>
void describe(Fields& fields, Self& figures) {
    fields.required("rel_rms", figures.relRms, kFigure, "RMS of the error over RMS of the reference");
    fields.required("p99", figures.p99, kFigure, "99th percentile of the local relative error");
    fields.required("max_sampled", figures.maxSampled, kFigure, "largest local relative error of a sample");
    fields.required("max_bound", figures.maxBound, kFigure, "certified bound on the local relative error");
    fields.optional("sampled_at", figures.sampledAt, "place of max_sampled: `texel`, `mip`, `face`, `channel`, `normal`, `view`, ...");
    fields.optional("bound_at", figures.boundAt, "place of max_bound");
}

struct StageShape {
    std::string name;
    std::optional<Json> seconds;
    FiguresShape diffuse, specular;
};
template <class Fields, Is<StageShape> Self>
void describe(Fields& fields, Self& stage) {
    fields.required("name", stage.name, "name of the stage");
    fields.optional("seconds", stage.seconds, "wall time of the verification, in the last stage");
    fields.object("error", "error after this stage", [&](auto& error) {
        error.required("diffuse", stage.diffuse, "of Lambert shading");
        error.required("specular", stage.specular, "of area-specular shading");
    });
}

struct FailureShape {
    std::string subject, detail, message;
};
template <class Fields, Is<FailureShape> Self>
void describe(Fields& fields, Self& failure) {
    fields.required("subject", failure.subject, "asset and place");
    fields.required("detail", failure.detail, "what was found and what was expected");
    fields.required("message", failure.message, "the whole line");
}

struct RowShape {
    std::string name, layout, metric;
    AssetKind kind = AssetKind::LightMap;
    int width = 0, height = 0;
    std::uint64_t bytesIn = 0, bytesGpu = 0, bytesDisk = 0;
    double bitsPerTexel = 0, seconds = 0, limit = 0;
    bool passed = false;
    std::vector<StageShape> stages;
    std::optional<std::vector<FailureShape>> failures;
    std::optional<LightFigures> light;
    std::optional<Json> verifySeconds, violations, textures, notes, key, meshError, preview, measures, groundTruth, trialCandidates,
        trialShare;
};
template <class Fields, Is<RowShape> Self>
void describe(Fields& fields, Self& row) {
    constexpr FieldRule kSide = between(0, kLargestSide);
    fields.required("name", row.name, "name of the asset");
    fields.required("kind", row.kind, "kind of asset");
    fields.required("width", row.width, kSide, "width [texels]");
    fields.required("height", row.height, kSide, "height [texels]");
    fields.required("bytes_in", row.bytesIn, kBytes, "size of the source [bytes]");
    fields.required("bytes_gpu", row.bytesGpu, kBytes, "GPU memory [bytes]");
    fields.required("bytes_disk", row.bytesDisk, kBytes, "size of the files [bytes]");
    fields.required("bits_per_texel", row.bitsPerTexel, kNotNegative, "GPU memory of a texel [bits]");
    fields.required("layout", row.layout, "layout of the textures");
    fields.required("seconds", row.seconds, kNotNegative, "wall time of the cook");
    fields.optional("verify_seconds", row.verifySeconds, "wall time of the verification");
    fields.required("stages", row.stages, atLeast(1), "errors after each stage; the last is the whole asset");
    fields.object("limit", "limit that the last stage is held to", [&](auto& limit) {
        limit.required("metric", row.metric, "figure that is limited");
        limit.required("value", row.limit, kNotNegative, "largest value that passes");
    });
    fields.required("passed", row.passed, "true if the figures are within the limit and nothing is violated");
    fields.optional("violations", row.violations, "faults that the figures average away: `place`, `found`, `expected`, `at`");
    fields.optional("textures", row.textures, "textures: `role`, `file`, `format`, `bytes_gpu`");
    fields.optional("notes", row.notes, "counts and facts of the cook");
    fields.optional("key", row.key, "log-average luminance of the exit radiance");
    fields.optional("light", row.light, "light that the errors are a part of");
    fields.optional("mesh_error", row.meshError, "how far quantization moved the vertices");
    fields.optional("preview", row.preview, "pictures: `reference`, `cooked`, `difference`");
    fields.optional("measures", row.measures, "further figures of the kind");
    fields.optional("ground_truth", row.groundTruth, "errors against traced light");
    fields.optional("failures", row.failures, "reasons of an asset that did not pass");
    fields.optional("trial_candidates", row.trialCandidates, "layouts that were tried: size and error of each");
    fields.optional("trial_share", row.trialShare, "part of the map that was tried");
}

struct PartShape {
    struct Stage {
        std::string name;
        double share = 0;
    };
    std::string asset, shading;
    AssetKind kind = AssetKind::LightMap;
    double share = 0, relRms = 0, lightRms = 0;
    std::vector<Stage> stages;
};
template <class Fields, Is<PartShape::Stage> Self>
void describe(Fields& fields, Self& stage) {
    fields.required("name", stage.name, "name of the stage");
    fields.required("share", stage.share, kFigure, "share of the squared error");
}
template <class Fields, Is<PartShape> Self>
void describe(Fields& fields, Self& part) {
    fields.required("asset", part.asset, "name of the asset");
    fields.required("kind", part.kind, "kind of asset");
    fields.required("shading", part.shading, "diffuse or specular");
    fields.required("share", part.share, kFigure, "share of the squared error");
    fields.required("rel_rms", part.relRms, kFigure, "rel_rms of the asset");
    fields.required("light_rms", part.lightRms, kFigure, "RMS of its light");
    fields.required("stages", part.stages, "shares of its stages");
}

struct ShadingShape {
    double relRms = 0, relRmsBound = 0, lightRms = 0;
    std::map<std::string, double> lights;
    std::vector<PartShape> parts;
};
template <class Fields, Is<ShadingShape> Self>
void describe(Fields& fields, Self& shading) {
    fields.required("rel_rms", shading.relRms, kFigure, "error of the shaded light, with independent parts");
    fields.required("rel_rms_bound", shading.relRmsBound, kFigure, "error if all parts add up");
    fields.required("light_rms", shading.lightRms, kFigure, "RMS of the shaded light");
    fields.required("lights", shading.lights, kFigure, "RMS of each kind of light");
    fields.required("parts", shading.parts, "assets that take part, the largest share first");
}

struct MapShape {
    std::string name;
    double weight = 0;
    ShadingShape shading;
};
template <class Fields, Is<MapShape> Self>
void describe(Fields& fields, Self& map) {
    fields.required("name", map.name, "name of the light map");
    fields.required("weight", map.weight, kFigure, "share of the covered texels");
    describe(fields, map.shading);
}

struct ApartShape {
    std::string asset;
    AssetKind kind = AssetKind::LightMap;
    double relRms = 0;
};
template <class Fields, Is<ApartShape> Self>
void describe(Fields& fields, Self& apart) {
    fields.required("asset", apart.asset, "name of the asset");
    fields.required("kind", apart.kind, "kind of asset");
    fields.required("rel_rms", apart.relRms, kFigure, "rel_rms of the asset");
}

struct WholeShape {
    ShadingShape shading;
    std::optional<std::vector<MapShape>> lightMaps;
    std::vector<ApartShape> apart;
};
template <class Fields, Is<WholeShape> Self>
void describe(Fields& fields, Self& whole) {
    describe(fields, whole.shading);
    fields.optional("light_maps", whole.lightMaps, "the same for each light map, if there are several");
    fields.required("apart", whole.apart, "assets that light no surface of the light maps");
}

struct ReportFile {
    std::string file, digest;
};
template <class Fields, Is<ReportFile> Self>
void describe(Fields& fields, Self& file) {
    fields.required("file", file.file, kFileInFolder, "manifest, page or picture");
    fields.required("digest", file.digest, "XXH3-128 of the file");
}

struct ReportShape {
    std::string scene;
    std::optional<Json> tool;
    bool passed = false;
    double seconds = 0, peakRssBytes = 0;
    std::vector<RowShape> assets;
    std::vector<Json> skipped;
    std::optional<Json> limitBytes;
    std::uint64_t usedBytes = 0;
    std::map<std::string, Json> byKind, byFormat;
    std::optional<WholeShape> whole;
    std::optional<std::vector<ReportFile>> files;
};
template <class Fields, Is<ReportShape> Self>
void describe(Fields& fields, Self& report) {
    fields.required("scene", report.scene, "name of the scene");
    fields.optional("tool", report.tool, "program that wrote the report: `name`, `version`");
    fields.required("passed", report.passed, "true if every asset passed and the budget holds");
    fields.required("seconds", report.seconds, kNotNegative, "wall time of the job");
    fields.required("peak_rss_bytes", report.peakRssBytes, kNotNegative, "most memory that was resident");
    fields.required("assets", report.assets, "a row for each asset");
    fields.required("skipped", report.skipped, "what was not cooked: `what`, `why`, `bytes_saved`, `seconds_saved`");
    fields.object("budget", "GPU memory", [&](auto& budget) {
        budget.optional("limit_bytes", report.limitBytes, "budget [bytes], null without one");
        budget.required("used_bytes", report.usedBytes, kBytes, "GPU memory of all assets");
        budget.required("by_kind", report.byKind, "GPU memory by kind of asset");
        budget.required("by_format", report.byFormat, "GPU memory by pixel format");
    });
    fields.optional("whole", report.whole, "error of the whole shading of the scene");
    fields.optional("files", report.files, "files that belong to this report");
}

}  // namespace

formats::Result<void> checkReport(const Json& report, const std::string& subject) {
    return checkedJson(report, subject, [](const JsonPlace& root) {
        ReportShape shape;
        readValue(root, shape, {});
        const JsonPlace limit = root["budget"]["limit_bytes"];
        if (!limit.value().is_null()) limit.integer(0, static_cast<std::int64_t>(kLargestBytes));
    });
}

std::string reportReference() {
    std::vector<FieldRow> rows = fieldRows<ReportShape>();
    rows.push_back({"digest", "string", "XXH3-128 of this file, taken with zeros for the digits of the digest itself"});
    return "# Report\n\n`report.json` adds up a cook or a verification: bytes against the budget, error against the limit, time. `[]` "
           "stands for each element of a list, `.*` for each member of an object whose keys are names. Figures that are not finite "
           "are `null`.\n\n" +
           markdownTable(rows);
}

}  // namespace lightcook::pipeline
