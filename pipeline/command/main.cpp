// The command line. Every command is a function from its options to an exit code; what it does lives elsewhere.
#include <fcntl.h>
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <functional>
#include <system_error>
#include <thread>

#include "compress/encode_options.h"
#include "fit/specular_tables.h"
#include "formats/nearest.h"
#include "pipeline/command/convert.h"
#include "pipeline/command/irradiance_command.h"
#include "pipeline/command/terminal.h"
#include "pipeline/command/texture_commands.h"
#include "pipeline/cook/cook.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/version.h"
#include "pipeline/manifest/json_shape.h"
#include "pipeline/report/ci_report.h"
#include "pipeline/report/explained_light.h"
#include "pipeline/report/report.h"
#include "pipeline/report/whole_error.h"

namespace lightcook::pipeline {
namespace {

using formats::Error;
using formats::ErrorCode;
using formats::Result;

RunState* interruptedState = nullptr;  ///< what the signal handler sets; set once, before any work
extern "C" void onInterrupt(int) {
    if (interruptedState != nullptr) interruptedState->interrupted = true;
}

/// What every command has.
struct Common {
    LogFormat log = LogFormat::Text;
    int threads = 0;
};

struct Session {
    explicit Session(const Common& common)
        : terminal(common.log),
          threads(common.threads > 0 ? common.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))) {
        state.progress = [this](const std::string& what, double fraction) { terminal.progress(what, fraction); };
        interruptedState = &state;
        std::signal(SIGINT, onInterrupt);
        std::signal(SIGTERM, onInterrupt);
    }
    ~Session() { interruptedState = nullptr; }

    int finish(const std::vector<Error>& errors) {
        for (const Error& error : errors) terminal.error(error);
        return errors.empty() ? 0 : exitCode(errors.front().code);
    }
    template <class T>
    int finish(const Result<T>& result) {
        return result ? 0 : finish(std::vector<Error>{result.error()});
    }

    Terminal terminal;
    RunState state;
    int threads;
};

std::string percent(const Json& value) {
    return value.is_number() ? fmt::format("{:8.3f} %", 100 * value.get<double>()) : "     not finite";
}

/// The report as a table for people.
void sayReport(Terminal& terminal, const Json& report) {
    terminal.say(fmt::format("{:24} {:10} {:12} {:>12} {:>9} {:>10} {:>10} {:>10} {:>12}  {}", "asset", "kind", "layout", "GPU bytes",
                             "bits/tx", "diffuse", "specular", "p99", "bound", "verdict"));
    for (const Json& asset : report.at("assets")) {
        const Json& error = asset.at("stages").back().at("error");
        const bool diffuseIsWorse = error.at("specular").at("p99").is_number() && error.at("diffuse").at("p99").is_number() &&
                                    error.at("diffuse").at("p99").get<double>() >= error.at("specular").at("p99").get<double>();
        const Json& worse = error.at(diffuseIsWorse ? "diffuse" : "specular");
        terminal.say(fmt::format(
            "{:24} {:10} {:12} {:12} {:9.2f} {} {} {} {}  {}", asset.at("name").get<std::string>(), asset.at("kind").get<std::string>(),
            asset.at("layout").get<std::string>(), asset.at("bytes_gpu").get<std::uint64_t>(), asset.at("bits_per_texel").get<double>(),
            percent(error.at("diffuse").at("rel_rms")), percent(error.at("specular").at("rel_rms")), percent(worse.at("p99")),
            percent(worse.at("max_bound")), asset.at("passed").get<bool>() ? "passed" : "FAILED"));
    }
    const Json& budget = report.at("budget");
    const std::string limit =
        budget.at("limit_bytes").is_number() ? fmt::format(" of {}", budget.at("limit_bytes").get<std::uint64_t>()) : "";
    terminal.say(fmt::format("{} bytes of GPU memory{}, {:.2f} s, {:.0f} MiB resident at most",
                             budget.at("used_bytes").get<std::uint64_t>(), limit, report.at("seconds").get<double>(),
                             report.at("peak_rss_bytes").get<double>() / 0x1p20));
    if (report.contains("whole")) terminal.say(lineOf(report.at("whole")));
}

/// Options that lie over [output] of a scene; shared by cook, demo and the single converters.
struct OutputOptions {
    std::string target, layout, container, budget;
    double maxError = 0;
    int effort = -1;
    std::optional<double> rdo;
    bool zstd = false;

    void add(CLI::App& app) {
        app.add_option("--target", target, "bc, astc or float")->check(CLI::IsMember({"bc", "astc", "float"}));
        std::vector<std::string> layouts = lightMapLayoutNames();
        layouts.push_back(kAutoLayout);
        app.add_option("--layout", layout, fmt::format("layout of light maps: {}", fmt::join(layouts, ", ")))
            ->check(CLI::IsMember(layouts));
        app.add_option("--container", container, "ktx2 or dds")->check(CLI::IsMember({"ktx2", "dds"}));
        app.add_option("--max-error", maxError, "bound on rel_rms of diffuse and specular, as a fraction")->check(CLI::PositiveNumber);
        app.add_option("--budget", budget, "GPU memory of the whole scene, such as \"2 MiB\"");
        app.add_option("--effort", effort, "of block encoders, 0 (fastest) to 9 (best)")->check(CLI::Range(0, 9));
        app.add_option("--rdo", rdo, "share by which the error of a row of BC blocks may grow for smaller files, such as 0.02")
            ->check(CLI::Range(0.0, kLargestRdo));
        app.add_flag("--zstd", zstd, "Zstandard supercompression inside KTX2");
    }
    Result<void> apply(CookOptions& options) const {
        if (!target.empty()) options.target = *targetFromName(target, "--target");
        if (!layout.empty()) options.lightMapLayout = layout;
        if (!container.empty()) options.container = container == "dds" ? formats::Container::Dds : formats::Container::Ktx2;
        if (maxError > 0) options.maxError = maxError;
        if (effort >= 0) options.effort = effort;
        options.rdo = rdo;
        if (zstd) options.zstd = true;
        if (budget.empty()) return {};
        const auto bytes = parseByteCount(budget, "--budget");
        if (!bytes) return tl::make_unexpected(bytes.error());
        options.budgetBytes = *bytes;
        return {};
    }
};

void addCook(CLI::App& app, Common& common, std::function<int()>& command) {
    auto* sub = app.add_subcommand("cook", "Cook a whole scene, incrementally, and verify it");
    auto options = std::make_shared<CookOptions>();
    auto output = std::make_shared<OutputOptions>();
    sub->add_option("scene", options->scene, "scene.toml")->required();
    sub->add_option("-o,--output", options->output, "output folder; default: <scene name>.cooked");
    output->add(*sub);
    sub->add_option("--depfile", options->depfile, "write the inputs as a Makefile rule");
    sub->add_option("--only", options->only, "cook this asset and what derives from it, leave the others as they are");
    sub->add_option("--cache", options->cache, "cache folder; default: $LIGHTCOOK_CACHE or the user's cache folder");
    sub->add_option("--samples", options->samples, "random positions that the verifier shades between texels, per texel")
        ->check(CLI::Range(0, 1000000));
    sub->add_flag("--force", options->force, "cook everything again");
    sub->add_flag("--keep-going", options->keepGoing, "after a failure do the rest; the first failure's code is returned");
    sub->add_flag("--repair", options->repair, "mend bad input values instead of refusing them, and report how many");
    sub->callback([=, &common, &command] {
        command = [=, &common] {
            Session session(common);
            if (auto applied = output->apply(*options); !applied) return session.finish(applied);
            const Outcome outcome = cookScene(*options, session.state);
            if (session.terminal.isInteractive() && outcome.report.is_object()) sayReport(session.terminal, outcome.report);
            return session.finish(outcome.errors);
        };
    });
}

void addVerify(CLI::App& app, Common& common, std::function<int()>& command) {
    auto* sub = app.add_subcommand("verify", "Reopen what was cooked; shade and bound it again from the bytes");
    struct Files {
        std::filesystem::path json, junit, sarif;
    };
    auto options = std::make_shared<VerifyOptions>();
    auto files = std::make_shared<Files>();
    sub->add_option("folder", options->folder, "output folder of cook")->required();
    sub->add_option("--sources", options->sources, "the scene's folder, where it moved");
    sub->add_option("--samples", options->samples, "random positions shaded between texels, per texel")->check(CLI::Range(0, 1000000));
    sub->add_option("--json", files->json, "write the report as JSON");
    sub->add_option("--junit", files->junit, "write JUnit XML");
    sub->add_option("--sarif", files->sarif, "write SARIF");
    sub->callback([=, &common, &command] {
        command = [=, &common] {
            Session session(common);
            Outcome outcome = verifyCooked(*options, session.state);
            const auto write = [&](const std::filesystem::path& file, const std::string& text) {
                if (file.empty()) return;
                if (auto written = writeFile(file, text); !written) outcome.errors.push_back(written.error());
            };
            const std::vector<Error> verdicts = outcome.errors;
            write(files->json, textOf(outcome.report) + "\n");
            write(files->junit, junitReport(outcome.report, verdicts, options->folder.string()));
            write(files->sarif, sarifReport(outcome.report, verdicts));
            if (outcome.report.is_object()) sayReport(session.terminal, outcome.report);  // last: whoever reads it may stop reading
            return session.finish(outcome.errors);
        };
    });
}

/// Over the budget's growth that was allowed.
std::vector<Error> compareWithBaseline(const Json& report, const std::filesystem::path& baseline, double failOverPercent) {
    const auto old = readReport(baseline);
    if (!old) return {old.error()};
    const double before = old->at("budget").at("used_bytes").get<double>(), now = report.at("budget").at("used_bytes").get<double>();
    const double growth = before > 0 ? 100 * (now / before - 1) : (now > 0 ? 100.0 : 0.0);
    if (growth <= failOverPercent) return {};
    return {{ErrorCode::OverBudget, baseline.string(),
             fmt::format("found {} bytes of GPU memory, {:.2f} % over the baseline's {}, expected at most {} % more", now, growth, before,
                         failOverPercent)}};
}

void addReport(CLI::App& app, Common& common, std::function<int()>& command) {
    auto* sub = app.add_subcommand("report", "Memory budgets and error, for people and CI");
    struct Options {
        std::filesystem::path folder, json, html, baseline;
        double failOver = 0;
    };
    auto options = std::make_shared<Options>();
    sub->add_option("folder", options->folder, "output folder of cook")->required();
    sub->add_option("--json", options->json, "write the report as JSON");
    sub->add_option("--html", options->html, "write the report as a page that stands alone");
    auto* baseline = sub->add_option("--baseline", options->baseline, "an older report.json to compare with");
    sub->add_option("--fail-over", options->failOver, "growth of GPU memory over the baseline that is allowed [percent]")->needs(baseline);
    sub->callback([=, &common, &command] {
        command = [=, &common] {
            Session session(common);
            const auto report = readReport(options->folder / kReportName);
            if (!report) return session.finish(report);
            std::vector<Error> errors;
            if (!options->json.empty())
                if (auto written = writeFile(options->json, textOf(*report) + "\n"); !written) errors.push_back(written.error());
            if (!options->html.empty())
                if (auto written = writeFile(options->html, renderReportHtml(*report, options->folder)); !written)
                    errors.push_back(written.error());
            if (!options->baseline.empty())
                for (Error& error : compareWithBaseline(*report, options->baseline, options->failOver)) errors.push_back(std::move(error));
            if (!isWithinBudget(*report))
                errors.push_back({ErrorCode::OverBudget, options->folder.string(),
                                  "found more GPU memory used than the scene's budget, expected at most the budget"});
            sayReport(session.terminal, *report);
            return session.finish(errors);
        };
    });
}

void addReconstruct(CLI::App& app, Common& common, std::function<int()>& command) {
    auto* sub = app.add_subcommand("reconstruct", "Write a cooked light map as the shader sees it, as a bake");
    struct Options {
        std::filesystem::path folder, output;
        std::string name;
    };
    auto options = std::make_shared<Options>();
    sub->add_option("folder", options->folder, "output folder of cook")->required();
    sub->add_option("name", options->name, "the light map's name")->required();
    sub->add_option("output", options->output, "EXR with 27 float channels")->required();
    sub->callback([=, &common, &command] {
        command = [=, &common] {
            Session session(common);
            return session.finish(reconstructLightMap(options->folder, options->name, options->output, session.state));
        };
    });
}

void addEncode(CLI::App& app, Common& common, std::function<int()>& command) {
    auto* sub = app.add_subcommand("encode", "Compress an image into a KTX2 or DDS texture");
    auto options = std::make_shared<EncodeCommand>();
    auto json = std::make_shared<std::filesystem::path>();
    auto weights = std::make_shared<std::vector<float>>();
    sub->add_option("input", options->input, "EXR, HDR or any image")->required();
    sub->add_option("output", options->output, ".ktx2 or .dds")->required();
    sub->add_option("--format", options->format, "bc1 bc3 bc4 bc4-snorm bc5 bc5-snorm bc6h-uf16 bc6h-sf16 bc7 astc-4x4-hdr ... rgba8-srgb")
        ->required();
    sub->add_option("--effort", options->effort, "0 (fastest) to 9 (best)")->check(CLI::Range(0, 9));
    sub->add_option("--rdo", options->rdo, "share by which the error of a row of BC blocks may grow so that Zstandard finds more to match")
        ->check(CLI::Range(0.0, kLargestRdo));
    sub->add_option("--json", *json, "write what was done as JSON");
    sub->add_flag("--cube", options->cube, "the input is a vertical strip of six cube faces");
    sub->add_flag("--zstd", options->zstd, "Zstandard supercompression inside KTX2");
    sub->add_flag("--repair", options->repair, "NaN, infinite and impossible negative values become zero and are counted");
    const std::map<std::string, compress::HdrMetric> metrics = {
        {"log", compress::HdrMetric::Log}, {"linear", compress::HdrMetric::Linear}, {"relative", compress::HdrMetric::Relative}};
    sub->add_option("--metric", options->metric, "log, linear or relative: the error that HDR formats make small")
        ->transform(CLI::CheckedTransformer(metrics));
    sub->add_option("--metric-scale", options->metricScale, "of log, log2(1 + x / scale), and relative, dx / (x + scale)");
    sub->add_option("--weights", *weights, "R,G,B,A: how much each channel counts")->delimiter(',')->expected(4);
    sub->add_option("--significance", options->significance, "image of the same size whose first channel says how much each texel counts");
    sub->callback([=, &common, &command] {
        if (!weights->empty()) std::copy_n(weights->begin(), 4, options->channelWeights.begin());
        command = [=, &common] {
            Session session(common);
            const auto facts = encodeTexture(*options, session.threads);
            if (!facts) return session.finish(facts);
            for (const char* key : {"clamped_high", "clamped_negative", "repaired"})
                if (facts->at(key).get<std::int64_t>() > 0)
                    session.terminal.warning(options->input.string(), fmt::format("{} values {}", facts->at(key).get<std::int64_t>(), key));
            if (!json->empty()) return session.finish(writeFile(*json, textOf(*facts) + "\n"));
            return 0;
        };
    });
}

void addDecode(CLI::App& app, Common& common, std::function<int()>& command) {
    auto* sub = app.add_subcommand("decode", "Decode a texture into a float EXR");
    auto options = std::make_shared<DecodeCommand>();
    sub->add_option("input", options->input, ".ktx2 or .dds")->required();
    sub->add_option("output", options->output, "EXR")->required();
    sub->add_option("--mip", options->mip, "which mip")->check(CLI::NonNegativeNumber);
    sub->add_option("--layer", options->layer, "which layer of an array")->check(CLI::NonNegativeNumber);
    sub->callback([=, &common, &command] {
        command = [=, &common] {
            Session session(common);
            return session.finish(decodeTexture(*options));
        };
    });
}

void sayJson(Terminal& terminal, const Json& json, const std::string& indent = "") {
    for (const auto& [key, value] : json.items()) {
        if (value.is_structured()) {
            terminal.say(fmt::format("{}{}:", indent, key));
            sayJson(terminal, value, indent + "  ");
        } else {
            terminal.say(fmt::format("{}{}: {}", indent, key, value.is_string() ? value.get<std::string>() : textOf(value)));
        }
    }
}

void addCompare(CLI::App& app, Common& common, std::function<int()>& command) {
    auto* sub = app.add_subcommand("compare", "What differs between two images, textures or cooked scenes");
    struct Options {
        std::filesystem::path a, b;
        std::string metric;
    };
    auto options = std::make_shared<Options>();
    sub->add_option("a", options->a, "the reference")->required();
    sub->add_option("b", options->b, "the other")->required();
    sub->add_option("--metric", options->metric, "print this figure alone")
        ->check(CLI::IsMember({"rmse", "rel_rmse", "log2_psnr_db", "max_abs"}));
    sub->callback([=, &common, &command] {
        command = [=, &common] {
            Session session(common);
            const auto differences = compareFiles(options->a, options->b);
            if (!differences) return session.finish(differences);
            if (options->metric.empty())
                sayJson(session.terminal, *differences);
            else if (differences->contains(options->metric))
                session.terminal.say(fmt::format("{}", differences->at(options->metric).get<double>()));
            else
                return session.finish(std::vector<Error>{
                    {ErrorCode::InvalidRequest, "--metric", "found two cooked scenes, expected two images or textures"}});
            return 0;
        };
    });
}

void addInfo(CLI::App& app, Common& common, std::function<int()>& command) {
    auto* sub = app.add_subcommand("info", "What a file or a cooked folder holds");
    struct Options {
        std::filesystem::path file;
        bool json = false;
    };
    auto options = std::make_shared<Options>();
    sub->add_option("file", options->file, "texture, image, light map, mesh, scene or cooked folder")->required();
    sub->add_flag("--json", options->json, "as JSON");
    sub->callback([=, &common, &command] {
        command = [=, &common] {
            Session session(common);
            const auto facts = describeFile(options->file);
            if (!facts) return session.finish(facts);
            if (options->json)
                session.terminal.say(textOf(*facts));
            else
                sayJson(session.terminal, *facts);
            return 0;
        };
    });
}

/// What a gradient averaged around an axis lost of its environment.
void sayAsymmetry(Terminal& terminal, const Json& report, LogFormat log) {
    if (!report.is_object() || report.at("assets").empty()) return;
    const Json measures = report.at("assets").at(0).value("measures", Json::object());
    if (!measures.contains("asymmetric_energy")) return;
    const double share = measures.at("asymmetric_energy").get<double>();
    terminal.say(log == LogFormat::JsonLines
                     ? Json({{"asymmetric_energy", share}}).dump()
                     : fmt::format("{:.3g} % of the light's energy was not symmetric around the axis", 100 * share));
}

/// cubemap --filter irradiance, with what it shares with the other converters.
int runIrradiance(IrradianceCommand command, const ConvertOptions& options, Session& session) {
    command.input = options.input;
    command.output = options.output;
    command.repair = options.repair;
    if (options.cook.target) command.target = nameOf(*options.cook.target);
    if (options.cook.maxError) command.maxError = *options.cook.maxError;
    command.textures.zstd = options.cook.zstd.value_or(false);
    command.textures.effort = options.cook.effort.value_or(command.textures.effort);
    command.textures.rdo = options.cook.rdo.value_or(0);
    const auto cooked = cookIrradiance(command);
    if (cooked && session.terminal.isInteractive()) sayJson(session.terminal, *cooked);
    return session.finish(cooked);
}

/// cubemap --filter sh.
int runSh(ShCommand command, const ConvertOptions& options, Session& session) {
    command.input = options.input;
    command.output = options.output;
    command.repair = options.repair;
    const auto cooked = cookSh(command);
    if (cooked && session.terminal.isInteractive()) sayJson(session.terminal, *cooked);
    return session.finish(cooked);
}

/// Which of cubemap's options belong to which --filter: the first that was given to another one, as an error.
Result<void> checkFilterOptions(const CLI::App& sub, const std::string& filter) {
    const std::pair<const char*, std::vector<std::string>> owners[] = {
        {"--wrap", {"irradiance", "sh"}}, {"--size", {"irradiance"}}, {"--normalize", {"sh"}}, {"--sh", {"specular"}}};
    for (const auto& [option, filters] : owners)
        if (sub.count(option) > 0 && std::find(filters.begin(), filters.end(), filter) == filters.end())
            return failure(ErrorCode::InvalidRequest, option,
                           fmt::format("found it with --filter {}, expected {}", filter, fmt::join(filters, " or ")));
    return {};
}

std::vector<std::string> axisNames(const std::vector<fit::AxisMapping>& mappings) {
    std::vector<std::string> names = {"auto"};
    for (const fit::AxisMapping& mapping : mappings) names.push_back(mapping.name);
    return names;
}

void addTableOptions(CLI::App& sub, ConvertOptions& options) {
    TableSettings& tables = options.tables;
    sub.add_option("--m", options.m, "roughness range: low,high")->delimiter(',')->expected(2);
    sub.add_option("--exponents", options.exponents, "the same for --lobe phong-power as exponents: low,high")->delimiter(',')->expected(2);
    sub.add_option("--lobe", tables.lobe, "beckmann, ggx, phong or phong-power")->check(CLI::IsMember(kLobeNames));
    sub.add_option("--normalization", tables.normalization, "energy, or halo3: four times as much")
        ->check(CLI::IsMember({"energy", "halo3"}));
    sub.add_option("--views", tables.viewCount, "columns")->check(CLI::Range(2, 1024))->capture_default_str();
    sub.add_option("--rows", tables.roughnessCount, "rows over exactly the range of m; default: those of 16 that the range needs")
        ->check(CLI::Range(1, 1024));
    sub.add_option("--view-axis", tables.viewAxis, "what columns measure; auto: whatever loses least between them")
        ->check(CLI::IsMember(axisNames(fit::viewMappings())));
    sub.add_option("--roughness-axis", tables.roughnessAxis, "likewise rows")->check(CLI::IsMember(axisNames(fit::roughnessMappings())));
}

void addConverter(CLI::App& app, const std::string& name, const std::string& what, Common& common, std::function<int()>& command) {
    auto* sub = app.add_subcommand(name, what);
    auto options = std::make_shared<ConvertOptions>();
    auto output = std::make_shared<OutputOptions>();
    options->converter = name;
    if (name != "lut") sub->add_option("input", options->input, "the source image")->required();
    sub->add_option("output", options->output, "a folder, or a .ktx2 or .dds file where there is one texture")->required();
    output->add(*sub);
    sub->add_flag("--repair", options->repair, "mend bad input values instead of refusing them");
    if (name == "lightmap" || name == "dominant") {
        sub->add_option("--phase", options->phase, "none or condon-shortley")->check(CLI::IsMember({"none", "condon-shortley"}));
        sub->add_option("--frame", options->frame, "world or tangent")->check(CLI::IsMember({"world", "tangent"}));
        sub->add_option("--quantity", options->quantity, "radiance or irradiance")->check(CLI::IsMember({"radiance", "irradiance"}));
        sub->add_option("--light-units", options->lightUnits, "radiometric or game")->check(CLI::IsMember({"radiometric", "game"}));
        sub->add_option("--firefly-limit", options->fireflyLimit, "how many times its brightest neighbour a texel may be; 0 believes all")
            ->capture_default_str();
    }
    if (name == "dominant") {
        sub->add_flag("--report", options->explain, "tell where one light cannot say what the map holds, and what a second would give");
        sub->add_option(
               "--fit", options->fit,
               "closed: direction of band 1; refined: the best direction; explained: dimmed where it leaves much; refined-ambient: beside "
               "ambient light")
            ->check(CLI::IsMember(kDominantFitNames));
    }
    auto irradiance = std::make_shared<IrradianceCommand>();
    auto coefficients = std::make_shared<ShCommand>();
    auto filter = std::make_shared<std::string>("specular");
    if (name == "cubemap") {
        sub->add_option("--sh", options->sh, "JSON with the probe's SH");
        sub->add_option("--filter", *filter,
                        "specular: prefiltered and pre-divided levels; irradiance: diffuse light, one level, one file; sh: nine "
                        "coefficients as JSON")
            ->check(CLI::IsMember({"specular", "irradiance", "sh"}));
        sub->add_option("--wrap", irradiance->wrap, "of irradiance and sh: wrapped diffuse, energy conserving, 0 (Lambert) to 1")
            ->check(CLI::Range(0.0, 1.0));
        sub->add_option("--normalize", coefficients->normalize,
                        "of sh: none, or d3dx: 16/17 of the light, so that nine coefficients show a game light of 1 as 1")
            ->check(CLI::IsMember({"none", "d3dx"}));
        sub->add_option("--size", irradiance->size, "of irradiance: texels of a face")->check(CLI::Range(1, 1024));
    }
    if (name == "rsrm") {
        sub->add_option("--exponents", options->exponents, "Phong exponents, one row each")->delimiter(',');
        sub->add_option("--encoding", options->encoding, "of a painted gradient: linear, srgb, or auto (PNG, JPEG, TGA, BMP are sRGB)")
            ->check(CLI::IsMember(kGradientEncodings));
        auto* axis = sub->add_option("--axis", options->axis, "X,Y,Z: the input is an environment, averaged around this direction")
                         ->delimiter(',')
                         ->expected(3);
        sub->add_option("--zones", options->zones, "zones of such an average")->check(CLI::Range(1, kMostGradientZones))->needs(axis);
        sub->add_option("--format", options->rsrmFormat, "rgba8, bc7, or bc4 (gradients of one colour)")
            ->check(CLI::IsMember(kRsrmFormats));
        sub->add_flag("--dither", options->dither, "carry what rounding leaves along each row (rgba8)");
    }
    if (name == "lut") addTableOptions(*sub, *options);
    sub->callback([=, &common, &command] {
        command = [=, &common] {
            Session session(common);
            if (auto applied = output->apply(options->cook); !applied) return session.finish(applied);
            if (name == "cubemap")
                if (auto checked = checkFilterOptions(*sub, *filter); !checked) return session.finish(checked);
            if (*filter == "irradiance") return runIrradiance(*irradiance, *options, session);
            if (*filter == "sh") {
                coefficients->wrap = irradiance->wrap;
                return runSh(*coefficients, *options, session);
            }
            const Outcome outcome = convert(*options, session.state);
            if (session.terminal.isInteractive() && outcome.report.is_object()) sayReport(session.terminal, outcome.report);
            if (outcome.errors.empty() && !options->axis.empty()) sayAsymmetry(session.terminal, outcome.report, common.log);
            if (!options->explain || !outcome.errors.empty()) return session.finish(outcome.errors);
            const auto explained = explain(*options, session.state);
            if (!explained) return session.finish(explained);
            if (common.log == LogFormat::JsonLines)
                session.terminal.say(explained->dump());
            else
                for (const std::string& line : linesOf(*explained)) session.terminal.say(line);
            return 0;
        };
    });
}

/// The example scene: beside an installed program, or in the source tree that this one was built from.
std::filesystem::path demoScene() {
    std::error_code code;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", code);
    const std::filesystem::path installed =
        program.parent_path().parent_path() / "share" / "lightcook" / "examples" / "cornell" / "scene.toml";
    if (std::filesystem::exists(installed, code)) return installed;
    return std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "examples" / "cornell" / "scene.toml";
}

void addDemo(CLI::App& app, Common& common, std::function<int()>& command) {
    auto* sub = app.add_subcommand("demo", "Cook, verify and report the scene that ships with the program");
    auto options = std::make_shared<CookOptions>();
    auto output = std::make_shared<OutputOptions>();
    options->output = "demo.cooked";
    sub->add_option("-o,--output", options->output, "output folder")->capture_default_str();
    output->add(*sub);
    sub->callback([=, &common, &command] {
        command = [=, &common] {
            Session session(common);
            if (auto applied = output->apply(*options); !applied) return session.finish(applied);
            options->scene = demoScene();
            const Outcome cooked = cookScene(*options, session.state);
            if (!cooked.errors.empty()) return session.finish(cooked.errors);
            const Outcome verified = verifyCooked({options->output, {}, {}}, session.state);
            if (verified.report.is_object()) sayReport(session.terminal, verified.report);
            if (verified.errors.empty())
                session.terminal.say(fmt::format("cooked and verified; the report is {}",
                                                 std::filesystem::absolute(options->output / kReportHtmlName).lexically_normal().string()));
            return session.finish(verified.errors);
        };
    });
}

/// The first word that stands where a command should and is none, with the nearest one; empty if there is no such word.
std::string unknownCommand(const CLI::App& app, int argc, char** argv) {
    std::vector<std::string> commands;
    for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) commands.push_back(sub->get_name());
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "-j" || word == "--threads" || word == "--log" || word == "--instructions") ++i;  // its value follows
        if (word.starts_with("-")) continue;
        if (std::find(commands.begin(), commands.end(), word) != commands.end()) return "";
        return fmt::format("the command '{}' (nearest is '{}')", word, formats::nearestName(word, commands));
    }
    return "";
}

int run(int argc, char** argv) {
    CLI::App app("lightcook cooks baked lighting into GPU textures and proves how far the shaded result is from the bake.", "lightcook");
    app.set_version_flag("--version", fmt::format("{} {}", kToolName, kToolVersion));
    app.require_subcommand(1);
    app.fallthrough();
    Common common;
    std::string log = "text";
    app.add_option("--log", log, "text or json: how errors are told")->check(CLI::IsMember({"text", "json"}));
    app.add_option("-j,--threads", common.threads, "threads; default: all")->check(CLI::Range(1, 1024));
    std::string instructions = "widest";
    app.add_option("--instructions", instructions, "widest or avx2: what the encoders may use; the bytes are the same")
        ->check(CLI::IsMember({"widest", "avx2"}));
    std::function<int()> command;
    addCook(app, common, command);
    addVerify(app, common, command);
    addReport(app, common, command);
    addConverter(app, "lightmap", "Compress one SH light map", common, command);
    addConverter(app, "dominant", "Dominant light of one SH light map", common, command);
    addConverter(app, "cubemap", "Prefilter and pre-divide one environment", common, command);
    addConverter(app, "lut", "Cook-Torrance tables", common, command);
    addConverter(app, "rsrm", "Radially symmetric reflection map of one gradient", common, command);
    addEncode(app, common, command);
    addDecode(app, common, command);
    addReconstruct(app, common, command);
    addCompare(app, common, command);
    addInfo(app, common, command);
    addDemo(app, common, command);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& mistake) {
        if (mistake.get_exit_code() == 0) return app.exit(mistake);  // --help, --version
        const std::string unknown = unknownCommand(app, argc, argv);
        const std::string found = unknown.empty() ? fmt::format("a mistake ({})", mistake.what()) : unknown;
        Terminal(log == "json" ? LogFormat::JsonLines : LogFormat::Text)
            .error({ErrorCode::InvalidRequest, "command line", fmt::format("found {}, expected what --help shows", found)});
        return exitCode(ErrorCode::InvalidRequest);
    }
    common.log = log == "json" ? LogFormat::JsonLines : LogFormat::Text;
    const std::size_t threads =
        common.threads > 0 ? static_cast<std::size_t>(common.threads) : std::max(1u, std::thread::hardware_concurrency());
    const tbb::global_control parallelism(tbb::global_control::max_allowed_parallelism, threads);
    try {
        // An arena of its own: the default one has no more slots than the machine has cores, whatever -j says.
        tbb::task_arena arena(static_cast<int>(threads));
        const int code = arena.execute([&] { return command(); });
        if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
        throw std::system_error(errno, std::generic_category(), "writing to standard output");
    } catch (const std::system_error& fault) {
        Terminal(common.log).error({ErrorCode::Internal, "the system", fmt::format("found '{}', expected it to go on", fault.what())});
        return exitCode(ErrorCode::Internal);
    } catch (const std::exception& fault) {
        Terminal(common.log)
            .error({ErrorCode::Internal, kToolName, fmt::format("found an internal fault ({}), expected none", fault.what())});
        return exitCode(ErrorCode::Internal);
    }
}

}  // namespace
}  // namespace lightcook::pipeline

int main(int argc, char** argv) {
    // A standard stream that is closed would give its number to the next file that opens, and messages would end up in there.
    for (int descriptor = ::open("/dev/null", O_RDWR); descriptor >= 0; descriptor = ::open("/dev/null", O_RDWR))
        if (descriptor > STDERR_FILENO) {
            ::close(descriptor);
            break;
        }
    return lightcook::pipeline::run(argc, argv);
}
