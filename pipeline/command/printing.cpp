#include "pipeline/command/printing.h"

#include <fmt/format.h>

#include "pipeline/manifest/json_shape.h"
#include "pipeline/report/whole_error.h"

namespace lightcook::pipeline {
namespace {

std::string percent(const Json& value) {
    return value.is_number() ? fmt::format("{:8.3f} %", 100 * value.get<double>()) : "     not finite";
}

}  // namespace

void printReport(Terminal& terminal, const Json& report) {
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

void printJson(Terminal& terminal, const Json& json, const std::string& indent) {
    for (const auto& [key, value] : json.items()) {
        if (value.is_structured()) {
            terminal.say(fmt::format("{}{}:", indent, key));
            printJson(terminal, value, indent + "  ");
        } else {
            terminal.say(fmt::format("{}{}: {}", indent, key, value.is_string() ? value.get<std::string>() : textOf(value)));
        }
    }
}

}  // namespace lightcook::pipeline
