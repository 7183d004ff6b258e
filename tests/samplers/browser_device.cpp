#include "tests/samplers/browser_device.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <stdexcept>

#include "formats/temporary_folder.h"

namespace lightcook::samplers {
namespace {

using nlohmann::json;

constexpr int kPatience = 60'000;  ///< [ms] timeout of an answer

std::string base64Of(std::span<const std::byte> bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned group = 0;
        for (std::size_t j = 0; j < 3; ++j) group = group << 8 | (i + j < bytes.size() ? std::to_integer<unsigned>(bytes[i + j]) : 0);
        for (std::size_t j = 0; j < 4; ++j) text += i + j > bytes.size() ? '=' : kDigits[group >> (18 - 6 * j) & 63];
    }
    return text;
}
template <class T>
std::string base64Of(std::span<const T> values) {
    return base64Of(std::as_bytes(values));
}

std::vector<std::byte> bytesOf(const std::string& base64) {
    static const auto kValues = [] {
        std::array<int, 256> values;
        values.fill(-1);
        const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        for (std::size_t i = 0; i < digits.size(); ++i) values[static_cast<unsigned char>(digits[i])] = static_cast<int>(i);
        return values;
    }();
    std::vector<std::byte> bytes;
    unsigned group = 0;
    int bits = 0;
    for (const char each : base64) {
        const int value = kValues[static_cast<unsigned char>(each)];
        if (value < 0) break;
        group = (group << 6 | static_cast<unsigned>(value)) & 0xffffff;
        bits += 6;
        if (bits < 8) continue;
        bits -= 8;
        bytes.push_back(static_cast<std::byte>(group >> bits & 255));
    }
    return bytes;
}

/// A Chromium that is controlled through its file descriptor 3 and answers through 4, with zero-terminated JSON messages.
class Browser {
public:
    Browser() {
        std::array<int, 2> told{}, answered{};
        if (::pipe2(told.data(), O_CLOEXEC) != 0 || ::pipe2(answered.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipes");
        child_ = ::fork();
        if (child_ == 0) becomeChromium(told[0], answered[1]);
        ::close(told[0]);
        ::close(answered[1]);
        to_ = told[1];
        from_ = answered[0];
    }
    ~Browser() {
        ::close(to_);
        ::close(from_);
        ::kill(-child_, SIGKILL);
        ::waitpid(child_, nullptr, 0);
    }
    Browser(const Browser&) = delete;
    Browser& operator=(const Browser&) = delete;

    /// Returns the result of a method. Throws the browser's error message.
    json call(const std::string& method, json parameters, const std::string& session = {}) {
        json message = {{"id", ++lastId_}, {"method", method}, {"params", std::move(parameters)}};
        if (!session.empty()) message["sessionId"] = session;
        send(message.dump());
        for (;;) {
            json answer = json::parse(receive());
            if (answer.value("id", 0) != lastId_) continue;  // an event
            if (answer.contains("error")) throw std::runtime_error(method + ": " + answer["error"].value("message", "no reason given"));
            return answer.at("result");
        }
    }

private:
    [[noreturn]] void becomeChromium(int in, int out) const {
        ::setpgid(0, 0);
        // Duplicated to free numbers first, so that neither dup2 overwrites the other's source.
        const int a = ::fcntl(in, F_DUPFD, 10), b = ::fcntl(out, F_DUPFD, 10), nothing = ::open("/dev/null", O_RDWR);
        for (const int stream : {0, 1, 2}) ::dup2(nothing, stream);
        ::dup2(a, 3);
        ::dup2(b, 4);
        const std::string profile = "--user-data-dir=" + profile_.path().string();
        ::execlp("chromium", "chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                 "--ignore-gpu-blocklist", "--disable-dev-shm-usage", "--no-first-run", profile.c_str(), "--remote-debugging-pipe",
                 "about:blank", static_cast<char*>(nullptr));
        ::_exit(127);
    }
    void send(const std::string& text) {
        const char* data = text.c_str();
        for (std::size_t left = text.size() + 1; left > 0;) {
            const ssize_t sent = ::write(to_, data, left);
            if (sent <= 0) throw std::runtime_error("the browser does not listen");
            data += sent;
            left -= static_cast<std::size_t>(sent);
        }
    }
    std::string receive() {
        for (;;) {
            if (const std::size_t end = pending_.find('\0', searched_); end != std::string::npos) {
                std::string message = pending_.substr(0, end);
                pending_.erase(0, end + 1);
                searched_ = 0;
                return message;
            }
            searched_ = pending_.size();
            pollfd wait{from_, POLLIN, 0};
            std::array<char, 1 << 16> buffer;
            const ssize_t got = ::poll(&wait, 1, kPatience) > 0 ? ::read(from_, buffer.data(), buffer.size()) : 0;
            if (got <= 0) throw std::runtime_error("the browser does not answer");
            pending_.append(buffer.data(), static_cast<std::size_t>(got));
        }
    }

    formats::TemporaryFolder profile_;
    pid_t child_ = -1;
    int to_ = -1, from_ = -1, lastId_ = 0;
    std::string pending_;
    std::size_t searched_ = 0;
};

}  // namespace

class BrowserDevice::Page {
public:
    Page() {
        const json target = browser_.call("Target.createTarget", {{"url", "about:blank"}});
        session_ = browser_.call("Target.attachToTarget", {{"targetId", target.at("targetId")}, {"flatten", true}})
                       .at("sessionId")
                       .get<std::string>();
        std::ifstream script(std::filesystem::path(LIGHTCOOK_SOURCE_DIR) / "tests/samplers/browser_page.js");
        std::ostringstream text;
        text << script.rdbuf();
        evaluate(text.str() + "\nnull");
    }
    json evaluate(const std::string& expression) {
        const json answer = browser_.call("Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}}, session_);
        if (answer.contains("exceptionDetails"))
            throw std::runtime_error(answer["exceptionDetails"].value("/exception/description"_json_pointer, std::string("no words")));
        return answer.at("result").value("value", json());
    }
    /// Calls function(arguments...).
    json call(const std::string& function, const json& arguments) { return evaluate(function + "(..." + arguments.dump() + ")"); }

private:
    Browser browser_;
    std::string session_;
};

std::unique_ptr<BrowserDevice> BrowserDevice::create(std::string& whyNot) try {
    if (std::system("command -v chromium > /dev/null 2>&1") != 0) {
        whyNot = "chromium is not installed (Debian: chromium)";
        return nullptr;
    }
    ::signal(SIGPIPE, SIG_IGN);
    auto page = std::make_unique<Page>();
    if (const std::string missing = page->call("start", json::array()).get<std::string>(); !missing.empty()) {
        whyNot = "chromium has " + missing;
        return nullptr;
    }
    return std::unique_ptr<BrowserDevice>(new BrowserDevice(std::move(page)));
} catch (const std::exception& fault) {
    whyNot = std::string("chromium: ") + fault.what();
    return nullptr;
}

BrowserDevice::BrowserDevice(std::unique_ptr<Page> page) : page_(std::move(page)) {}
BrowserDevice::~BrowserDevice() = default;

std::string BrowserDevice::name() const {
    return page_->call("rendererName", json::array()).get<std::string>();
}

bool BrowserDevice::upload(int unit, const Ktx2& texture) {
    constexpr std::size_t kPiece =
        3 << 22;  // bytes: Chromium accepts messages of up to 100 MiB; multiples of three need no padding in base64
    for (std::size_t level = 0; level < texture.levels.size(); ++level) {
        const std::span<const std::byte> bytes(texture.levels[level]);
        for (std::size_t at = 0; at < bytes.size(); at += kPiece)
            page_->call("piece", {level, base64Of(bytes.subspan(at, std::min(kPiece, bytes.size() - at)))});
    }
    return page_
        ->call("upload", {unit, texture.vkFormat, texture.width, texture.height, std::max(texture.layerCount, 1), texture.faceCount})
        .get<bool>();
}

std::vector<glm::vec4> BrowserDevice::run(const std::string& declarations, const std::string& body, std::span<const glm::vec4> places,
                                          std::span<const glm::vec4> directions, std::span<const float> table) {
    // GLSL ES 3.00 has no layout(binding): the page sets the units.
    static const std::regex kSampler(R"(layout\(binding = (\d+)\) uniform (\w+) (\w+);)");
    json samplers = json::array();
    for (std::sregex_iterator each(declarations.begin(), declarations.end(), kSampler), end; each != end; ++each)
        samplers.push_back({(*each)[3].str(), std::stoi((*each)[1].str())});
    const std::string text =
        "#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\n"
        "precision highp sampler2DArray;\nprecision highp samplerCube;\n"
        "uniform sampler2D lcPlaces;\nuniform sampler2D lcDirections;\nuniform sampler2D lcTable;\n"
        "out vec4 result;\n"
        "#define TABLE(at) texelFetch(lcTable, ivec2((at) % 1024, (at) / 1024), 0).x\n" +
        std::regex_replace(declarations, kSampler, "uniform $2 $3;") +
        "\nvoid main() {\nivec2 lcAt = ivec2(gl_FragCoord.xy);\nvec4 place = texelFetch(lcPlaces, lcAt, 0);\n"
        "vec4 direction = texelFetch(lcDirections, min(lcAt, textureSize(lcDirections, 0) - 1), 0);\n" +
        body + "\n}\n";
    const std::array<glm::vec4, 1> none{};
    const std::array<float, 1> noTable{};
    const json answer = page_->call("run", {text, samplers, base64Of(places), base64Of(directions.empty() ? std::span(none) : directions),
                                            base64Of(table.empty() ? std::span(noTable) : table)});
    const std::vector<std::byte> bytes = bytesOf(answer.get<std::string>());
    std::vector<glm::vec4> results(places.size());
    if (bytes.size() < results.size() * sizeof(glm::vec4)) throw std::runtime_error("the browser gave too few results");
    std::memcpy(results.data(), bytes.data(), results.size() * sizeof(glm::vec4));
    return results;
}

}  // namespace lightcook::samplers
