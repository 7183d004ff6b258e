#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "pipeline/assets/results.h"
#include "pipeline/command/command.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/graph/action_result.h"
#include "pipeline/graph/cache.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/file_list.h"
#include "pipeline/graph/http_client.h"
#include "pipeline/graph/job.h"
#include "pipeline/graph/key_log.h"
#include "pipeline/graph/work_rates.h"
#include "pipeline/manifest/contract.h"
#include "pipeline/manifest/self_digest.h"
#include "pipeline/report/budgets.h"
#include "pipeline/report/ci_report.h"
#include "pipeline/report/history.h"
#include "pipeline/report/page.h"
#include "pipeline/view/server.h"
#include "tests/fuzz/target.h"
#include "tests/pipeline/fuzz/loopback.h"

namespace lightcook::pipeline {
namespace {

using fuzz::asFile, fuzz::Bytes, fuzz::require;

// --- documents --------------------------------------------------------------------------------------------------------------------------

void readSceneFile(Bytes bytes) {
    const std::filesystem::path file = asFile("scene.toml", bytes);
    GivenKeys given;  // as on a command line
    given.set("output.target", "astc");
    given.set("output.max_error", "2%");
    given.set("light_map.phase", "none");
    given.set("tables.views", "8");
    (void)readScenes(file, given);
    const auto scenes = readScenes(file);
    if (!scenes) return;
    for (const Scene& scene : *scenes) {
        const auto again = readSceneDocument(scene.document, scene.directory);
        require(again.has_value() && again->document == scene.document, "a scene is read from its document as from its file");
    }
}

void readBudgetsFile(Bytes bytes) {
    const auto budgets = readBudgets(asFile("budgets.toml", bytes));
    if (!budgets) return;
    const std::vector<SceneMemory> scenes = {{"room", "bc", 1 << 20, {{"light_map", 1 << 20}}, {{"bc6h-uf16", 1 << 20}}},
                                             {"hall", "astc", 0, {}, {}}};
    (void)errorsOf(usesOf(*budgets, scenes), budgets->file);
    (void)warningOfUnknownScenes(*budgets, scenes);
    (void)warningOfUnusedPlatforms(*budgets, scenes);
}

void readManifestFile(Bytes bytes) {
    const std::filesystem::path folder = asFile(kManifestName, bytes).parent_path();
    (void)checkSelfDigest(fuzz::textOf(bytes), kManifestName);
    const auto manifest = loadManifest(folder);
    if (!manifest) return;
    const auto again = fromJson<Manifest>(toJson(*manifest), kManifestName);
    require(again && toJson(*again) == toJson(*manifest), "a manifest is read as it was written");
    (void)checkDigests(folder, *manifest);
    (void)checkContract(folder, *manifest);
    (void)shaderTextOf(manifest->assets, manifest->lobe);
    for (const CookRecord& cook : manifest->cooks) (void)readSceneDocument(cook.scene, folder);
    for (const CookedAsset& asset : manifest->assets) (void)unchangedSources(asset, folder / manifest->sceneDirectory);
}

void readReportFile(Bytes bytes) {
    const std::filesystem::path file = asFile("report.json", bytes), folder = file.parent_path();
    (void)readBaselineScenes(file);
    auto report = loadReport(file);
    if (!report) return;
    const auto json = readReport(file);
    require(json.has_value(), "a report is JSON");
    const auto again = fromJson<Report>(toJson(*report), "report.json");
    require(again && toJson(*again) == toJson(*report), "a report is read as it was written");
    const BaselineComparison baseline = compareWithBaseline(*report, *again, "report.json", {1, 1});
    const std::vector<formats::Error> errors;
    const CiRun run = ciRun({"verify", folder, {}, {}, *json, errors, &report->findings});
    (void)junitReport(run);
    (void)sarifReport(run);
    (void)checkReportFiles({folder}, "", *report);
    (void)renderReportHtml(*report, folder, {historyLine(*report, "bc")});
    const CookedFolder cooked{folder, *json, *report, "bc", errors};
    CollectionReport collection = makeCollection({cooked, cooked});
    collection.baseline = compareCollections(collection, {summaryOf(cooked)}, file, {1, 1});
    (void)renderCollectionHtml(collection, {}, {});
    Terminal terminal(LogFormat::Text);
    printReport(terminal, *report);
    printFindings(terminal, report->findings);
    printClampedLight(terminal, *report);
    printRepairs(terminal, *report);
    printSkipped(terminal, *report);
    printComparison(terminal, baseline);
    printCollection(terminal, collection);
}

// --- caches and what lies beside them ---------------------------------------------------------------------------------------------------

/// The bytes are a record without the line of its digest, behind which no other one would be read.
void readRecord(Bytes bytes) {
    const std::string key(32, 'a'), text = fuzz::textOf(bytes);
    (void)Cache::parse(key, text);
    const auto record = Cache::parse(key, digestOfText(key + "\n" + text) + "\n" + text);
    if (!record) return;
    for (const FileRecord& file : record->files)
        require(file.name.find("..") != 0 && !file.name.starts_with('/') && file.digest.find('/') == std::string::npos,
                "a record names files of its folders");
    (void)fromJson<CookResult>(record->result, record->id);
    (void)fromJson<VerifyResult>(record->result, record->id);
    (void)fromJson<WholeFigures>(record->result, record->id);
    (void)fromJson<CookedAsset>(record->result, record->id);
}

/// The small files of caches, clusters and output folders.
void readState(Bytes bytes) {
    const std::string text = fuzz::textOf(bytes);
    const Cache cache(fuzz::inputFolder() / "cache", kCacheLimitBytes);
    std::filesystem::create_directories(cache.root() / "runs");
    formats::writeContent(cache.root() / "runs" / "a", text);
    (void)cache.findRun("a");
    const std::filesystem::path file = asFile("state", bytes);
    (void)readHistory(file);
    (void)readFileList(file);
    (void)WorkRates(file).secondsOf("light_map", 1e6);
    KeyLog keys(file, [](const Action&, bool, const std::string&) {});
    Action action;
    action.id = "a";
    action.dependencies = {"b"};
    const Json key = {{"tool", "c"},      {"kind", "k"}, {"asset", "a"}, {"parameters", {{"effort", 5}}}, {"inputs", Json::object()},
                      {"upstream", {"d"}}};
    keys.add(action, key, ResultSource::Run, true);
    (void)readJob(text, "node");
    Json job = parseJson(text);
    if (!job.is_object()) return;
    Job own;
    own.program = thisProgram();
    job["program"] = parseJson(textOfJob(own))["program"];
    if (const auto read = readJob(job.dump(-1, ' ', false, Json::error_handler_t::replace), "node"))
        require(readJob(textOfJob(*read), "node").has_value(), "a job is read as it was written");
}

void readResult(Bytes bytes) {
    const auto files = readActionResult(fuzz::textOf(bytes));
    if (files) require(readActionResult(actionResultText(*files)) == files, "a result is read as it was written");
}

void readAnswer(Bytes bytes) {
    static fuzz::AnsweringServer server;
    static const HttpServer address(*parseHttpUrl("http://127.0.0.1:" + std::to_string(server.port())), "");
    constexpr std::uint64_t kLimit = 4096;
    server.setAnswer(fuzz::textOf(bytes));
    HttpConnection connection(address, [] { return false; });
    std::string body;
    (void)connection.get("a", kLimit, [&](std::string_view piece) {
        body += piece;
        return true;
    });
    require(body.size() <= kLimit, "no more than the limit of a body is taken");
    (void)connection.head("a");
    std::istringstream content("content");
    (void)connection.put("a", content, 7);
    (void)parseHttpUrl(fuzz::textOf(bytes));
    (void)authorizationOf(fuzz::textOf(bytes));
}

// --- the command line, and the server of the page ---------------------------------------------------------------------------------------

/// Another working folder, while it exists.
class WorkingFolder {
public:
    explicit WorkingFolder(const std::filesystem::path& folder) : before_(std::filesystem::current_path()) {
        std::filesystem::current_path(folder);
    }
    ~WorkingFolder() { std::filesystem::current_path(before_); }
    WorkingFolder(const WorkingFolder&) = delete;
    WorkingFolder& operator=(const WorkingFolder&) = delete;

private:
    std::filesystem::path before_;
};

/// Each line is an argument.
void readCommandLine(Bytes bytes) {
    const WorkingFolder empty(fuzz::inputFolder() / "");
    std::vector<std::string> words = {"lightcook"};
    std::istringstream lines(fuzz::textOf(bytes));
    for (std::string line; std::getline(lines, line);) words.push_back(line.c_str());
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    GlobalOptions global;
    const ParsedCommandLine parsed = parseCommandLine(static_cast<int>(arguments.size()), arguments.data(), global);
    require(parsed.function || parsed.exitCode == 0 || parsed.exitCode == 2, "a command line that is not taken ends with 0 or 2");
}

constexpr std::size_t kPageBytes = 16 << 10;

/// `lightcook view` of a cooked folder without assets.
class ShownSite {
public:
    ShownSite() {
        Manifest manifest;
        manifest.scene = "room";
        manifest.tool = {"lightcook", "0"};
        manifest.target = "bc";
        manifest.workingColor = "lin_rec709";
        manifest.shader = {kShaderName, digestOfText("void main() {}")};
        manifest.cooks.emplace_back().scene = Json::object();
        formats::writeContent(folder_ / kShaderName, "void main() {}");
        formats::writeContent(folder_ / kManifestName, withSelfDigest(toJson(manifest)));
        auto site = open();
        if (!site) throw std::runtime_error(site.error().line());
        site_.emplace(std::move(*site));
        auto server = SiteServer::open(*site_, 0, [this] { return open(); });
        if (!server) throw std::runtime_error(server.error().line());
        server_.emplace(std::move(*server));
        thread_ = std::thread([this] { server_->run(state_); });
    }
    ~ShownSite() {
        state_.interrupted = true;
        thread_.join();
    }
    ShownSite(const ShownSite&) = delete;
    ShownSite& operator=(const ShownSite&) = delete;

    int port() const { return server_->port(); }

private:
    formats::Result<Site> open() const { return Site::open({folder_ / "", {}, page_}, state_); }

    formats::TemporaryFolder folder_;
    std::string text_ = std::string(kPageBytes, 'p');
    std::array<BundledFile, 1> page_ = {BundledFile{"index.html", text_}};
    RunState state_;
    std::optional<Site> site_;
    std::optional<SiteServer> server_;
    std::thread thread_;
};

/// The bytes are a request, in which $PORT stands for the server's port. The server closes after its answer, as the second line asks it to.
void answerRequest(Bytes bytes) {
    static const ShownSite site;
    std::string request = fuzz::textOf(bytes);
    request.insert(std::min(request.find("\r\n"), request.size()), "\r\nConnection: close");
    request += "\r\n\r\n";
    for (std::size_t at = request.find("$PORT"); at != std::string::npos; at = request.find("$PORT", at))
        request.replace(at, 5, std::to_string(site.port()));
    const fuzz::Socket socket;
    socket.connect(site.port());
    socket.limitSilence(std::chrono::milliseconds(20));  // after an answer to a request that is none, the server waits for the next one
    socket.sendAll(request);
    const std::string answer = socket.receiveAll();
    require(answer.empty() || answer.starts_with("HTTP/1.1 "), "an answer is HTTP");
    constexpr std::size_t kHeadBytes = 2048;
    require(answer.size() <= kPageBytes + kHeadBytes, "an answer is no longer than a file and its head");
}

constexpr std::array kFuzzTargets = {
    fuzz::Target{"scene-file", readSceneFile}, fuzz::Target{"budgets", readBudgetsFile}, fuzz::Target{"manifest", readManifestFile},
    fuzz::Target{"report", readReportFile},    fuzz::Target{"record", readRecord},       fuzz::Target{"state", readState},
    fuzz::Target{"result", readResult},        fuzz::Target{"answer", readAnswer},       fuzz::Target{"commands", readCommandLine},
    fuzz::Target{"request", answerRequest},
};

}  // namespace
}  // namespace lightcook::pipeline

std::span<const lightcook::fuzz::Target> lightcook::fuzz::targets() {
    return pipeline::kFuzzTargets;
}
