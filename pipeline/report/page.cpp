#include "pipeline/report/page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "formats/pixel_format.h"
#include "pipeline/report/bundle.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

/// Escapes text for elements. Control characters, which HTML forbids, become U+FFFD.
std::string escaped(std::string_view plain) {
    std::string out;
    for (const char c : plain) {
        const auto code = static_cast<unsigned char>(c);
        if (c == '&')
            out += "&amp;";
        else if (c == '<')
            out += "&lt;";
        else if (c == '>')
            out += "&gt;";
        else if ((code < 0x20 && c != '\n' && c != '\t') || code == 0x7f)
            out += "\uFFFD";
        else
            out += c;
    }
    return out;
}

/// Returns JSON for a script element, which it cannot end or extend: it has no "<", and no character beyond ASCII.
std::string scriptText(const Json& json) {
    std::string out;
    for (const char c : json.dump(-1, ' ', true, Json::error_handler_t::replace)) {
        if (c == '<')
            out += "\\u003c";
        else
            out += c;
    }
    return out;
}

std::string base64(std::string_view bytes) {
    static constexpr std::string_view kBase64Digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
        std::uint32_t group = 0;
        for (std::size_t i = 0; i < 3; ++i) group = group << 8 | (i < count ? static_cast<unsigned char>(bytes[at + i]) : 0u);
        for (std::size_t digit = 0; digit < 4; ++digit) out += digit <= count ? kBase64Digits[group >> (18 - 6 * digit) & 63] : '=';
    }
    return out;
}

/// Adds a picture under the name that the report has. Leaves out a file that is missing or not a PNG.
void addPicture(const std::string& name, const std::filesystem::path& file, Json& pictures) {
    constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
    constexpr std::size_t kHeaderBytes = 33;  // signature and the whole IHDR chunk
    const auto bytes = readFile(file);
    if (bytes && bytes->size() >= kHeaderBytes && bytes->starts_with(kSignature))
        pictures[name] = "data:image/png;base64," + base64(*bytes);
}

void addPictures(const std::vector<AssetChange>& assets, Json& pictures) {
    for (const AssetChange& asset : assets)
        for (const auto& file : {asset.pictureBefore, asset.pictureNow})
            if (file) addPicture(*file, *file, pictures);
}

Json useOf(const std::optional<LimitUse>& use) {
    return use ? Json{{"share", use->share}, {"words", use->words}} : Json();
}

/// Returns the members that every page has.
Json dataOf(const std::vector<HistoryLine>& history) {
    Json data = {{"history", jsonOf(history)}, {"uses", Json::array()}, {"pictures", Json::object()}};
    for (const AssetKindInfo& kind : allAssetKinds()) data["kinds"][std::string(kind.name)] = kind.shortCaption;
    for (const formats::PixelFormatInfo& format : formats::allPixelFormats())
        data["formats"][std::string(format.name)] = {{"side", format.blockWidth}, {"bytes", format.bytesPerBlock}};
    return data;
}

// The page without scripts

using Row = std::vector<std::string>;

std::string tableText(const Row& head, const std::vector<Row>& rows) {
    std::string out = "<table>\n<thead><tr>";
    for (const std::string& name : head) out += "<th>" + escaped(name) + "</th>";
    out += "</tr></thead>\n<tbody>\n";
    for (const Row& row : rows) {
        out += "<tr>";
        for (const std::string& content : row) out += "<td>" + escaped(content) + "</td>";
        out += "</tr>\n";
    }
    return out + "</tbody>\n</table>\n";
}

std::string htmlList(const std::vector<std::string>& lines) {
    std::string out;
    for (const std::string& line : lines) out += "<li>" + escaped(line) + "</li>\n";
    return out.empty() ? out : "<ul>\n" + out + "</ul>\n";
}

const char* verdictText(bool isPassed) {
    return isPassed ? "passed" : "failed";
}

/// Returns verdict, failures and a table as HTML.
std::string plainText(const std::string& title, const std::string& verdict, const std::vector<std::string>& failures, const Row& head,
                      const std::vector<Row>& rows) {
    return fmt::format("\n<h1>{}</h1>\n<p>{}</p>\n{}{}<p>Scripts show pictures, places and plots.</p>\n", escaped(title), escaped(verdict),
                       htmlList(failures), tableText(head, rows));
}

std::string pageText(const std::string& title, const std::string& plain, const Json& data) {
    std::string page(reportTemplate());
    // The last place first, so that what was put in is not searched.
    for (const auto& [place, text] :
         {std::pair{"<!--data-->", scriptText(data)}, std::pair{"<!--table-->", plain}, std::pair{"<!--title-->", escaped(title)}})
        if (const std::size_t at = page.find(place); at != std::string::npos) page.replace(at, std::string_view(place).size(), text);
    return page;
}

/// Returns the link to the page of a scene, relative to this page; empty without one.
std::string linkOf(const SceneSummary& scene, const std::filesystem::path& page) {
    if (page.empty()) return "";
    std::error_code code;
    const std::filesystem::path target = std::filesystem::absolute(std::filesystem::path(scene.folder) / kReportHtmlName, code);
    const std::filesystem::path from = std::filesystem::absolute(page, code).parent_path();
    // Percent signs and other reserved characters of folder names are encoded.
    std::string link;
    for (const char c : target.lexically_normal().lexically_relative(from.lexically_normal()).generic_string()) {
        const bool isPlain =
            std::isalnum(static_cast<unsigned char>(c)) != 0 || std::string_view("-._~/").find(c) != std::string_view::npos;
        link += isPlain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return link;
}

}  // namespace

std::string renderReportHtml(const Report& report, const StagedFolder& folder, const std::vector<HistoryLine>& history) {
    Json data = dataOf(history), &pictures = data["pictures"];
    Json& json = data["report"] = toJson(report);
    json.erase("files");
    json.erase("digest");
    for (const std::string& file : picturesOf(report.assets)) addPicture(file, folder.of(file) / file, pictures);
    if (report.baseline) addPictures(report.baseline->assets, pictures);

    std::vector<std::string> failures;
    if (report.incomplete)
        for (const std::string& asset : report.incomplete->assets) failures.push_back(asset + ": not cooked");
    std::vector<Row> rows;
    std::size_t passed = 0;
    if (!report.budget.isKept()) failures.push_back("memory budget: " + report.budget.advice);
    for (const ReportRow& row : report.assets) {
        data["uses"].push_back(useOf(mostUsedLimit(row)));
        const verify::StageError& last = row.verdict.stages.back();
        const bool isFinite = std::isfinite(last.diffuse.relRms) && std::isfinite(last.specular.relRms);
        rows.push_back({row.name, fmt::format("{}", row.bytesGpu),
                        humanPercent(isFinite ? std::max(last.diffuse.relRms, last.specular.relRms) : std::nan("")),
                        row.verdict.limits[Limit::Error] ? humanPercent(*row.verdict.limits[Limit::Error]) : "",
                        verdictText(row.verdict.passed)});
        passed += row.verdict.passed ? 1 : 0;
        for (const Failure& failure : row.failures) failures.push_back(failure.message);
    }
    const std::string budget = report.budget.limitBytes ? " of " + sizeWords(*report.budget.limitBytes) : "";
    const std::string verdict = fmt::format("{}: {} of {} passed, {}{} of GPU memory", verdictText(report.passed), passed,
                                            counted(rows.size(), "asset"), sizeWords(report.budget.usedBytes), budget) +
                                (report.partial.empty() ? "" : fmt::format("; cook --only left out {}", fmt::join(report.partial, ", ")));
    return pageText(
        fmt::format("{}: {}", report.scene, verdictText(report.passed)),
        plainText(report.scene, verdict, failures, {"Asset", "GPU memory [bytes]", "Error (rel_rms)", "Limit", "Verdict"}, rows), data);
}

std::string renderCollectionHtml(const CollectionReport& report, const std::filesystem::path& page,
                                 const std::vector<HistoryLine>& history) {
    Json data = dataOf(history);
    data["collection"] = toJson(report);
    data["links"] = Json::array();
    std::vector<std::string> failures, errors;
    std::vector<Row> rows;
    std::size_t passed = 0;
    for (const SceneSummary& scene : report.scenes) {
        Json uses = Json::array();
        for (const AssetSummary& asset : scene.assets) uses.push_back(useOf(asset.limitUse));
        data["uses"].push_back(std::move(uses));
        data["links"].push_back(linkOf(scene, page));
        rows.push_back({scene.name, scene.target, fmt::format("{}", scene.budget.usedBytes),
                        scene.sceneError ? humanPercent(*scene.sceneError) : "", verdictText(scene.passed)});
        passed += scene.passed ? 1 : 0;
        for (const std::string& error : scene.errors) failures.push_back(fmt::format("{}: {}", scene.name, error));
    }
    if (report.platforms)
        for (const formats::Error& error : errorsOf(*report.platforms, "budgets")) errors.push_back(error.line());
    failures.insert(failures.end(), errors.begin(), errors.end());
    data["errors"] = errors;
    constexpr std::size_t kMostPictured = 12;
    if (report.baseline)
        for (const SceneChange& scene : report.baseline->scenes)
            for (const AssetChange& asset : scene.assets)
                if (asset.pictureNow && data["pictures"].size() < 2 * kMostPictured) addPictures({asset}, data["pictures"]);
    const std::string title = counted(rows.size(), "scene");
    const std::string verdict =
        fmt::format("{}: {} of {} passed, {} of GPU memory", verdictText(report.passed), passed, title, sizeWords(report.totals.bytesGpu));
    return pageText(fmt::format("{}: {}", title, verdictText(report.passed)),
                    plainText(title, verdict, failures, {"Scene", "Target", "GPU memory [bytes]", "Error of the whole", "Verdict"}, rows),
                    data);
}

}  // namespace lightcook::pipeline
