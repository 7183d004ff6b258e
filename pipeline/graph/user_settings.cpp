#include "pipeline/graph/user_settings.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <system_error>

#include "pipeline/document/toml_fields.h"
#include "pipeline/document/written_path.h"
#include "pipeline/graph/http_client.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

constexpr const char* kSection = "cache";
constexpr const char* kRemoteCache = "remote_cache";
constexpr const char* kRemoteUpload = "remote_upload";
constexpr const char* kRemoteCredentials = "remote_credentials";

std::string textOf(const std::string& variable) {
    const char* const value = std::getenv(variable.c_str());
    return value == nullptr ? "" : value;
}

/// Empty: this user has no folder for it. A relative $XDG_CONFIG_HOME does not count: the XDG Base Directory Specification calls it
/// invalid.
std::filesystem::path configurationFile() {
    std::filesystem::path folder = textOf("XDG_CONFIG_HOME");
    if (const std::string home = textOf("HOME"); !folder.is_absolute())
        folder = home.empty() ? "" : std::filesystem::path(home) / ".config";
    return folder.empty() ? folder : folder / "lightcook" / "config.toml";
}

std::string faultOfAddress(const std::string& text) {
    const auto url = parseHttpUrl(text);
    return url ? "" : url.error().detail;
}

/// Variables of the environment give the keys that no option gives.
void addVariables(GivenKeys& given, CacheSettings& cache) {
    for (const KeyRow& row : cacheKeyTable().keys) {
        const std::string key = fmt::format("{}.{}", kSection, row.name), variable = variableOf(row);
        std::string text = textOf(variable);
        if (text.empty() || given.find(key) != nullptr) continue;
        if (row.name == kRemoteCredentials) {  // itself, not its file
            cache.credentials = text;
            continue;
        }
        if (const std::string fault = row.shape == KeyShape::Path ? faultOfHome(text) : ""; !fault.empty())
            throw TomlMistake{{formats::ErrorCode::InvalidRequest, "$" + variable, fault}};
        if (row.shape == KeyShape::Flag && (text == "0" || text == "1")) text = text == "1" ? "true" : "false";
        given.set(key, text, "$" + variable);
    }
}

/// Upload and credentials of the file are for its own remote cache. They are removed where an option or a variable names another one.
void keepToOwnServer(const TomlDocument& document, toml::table& root, const GivenKeys& given) {
    toml::table* const cache = root[kSection].as_table();
    if (cache == nullptr) return;
    for (const char* key : {kRemoteUpload, kRemoteCredentials})
        if (const toml::node* node = cache->get(key); node != nullptr && !cache->contains(kRemoteCache))
            document.fail(*node, fmt::format("found {} without {}, expected the address that it is for", key, kRemoteCache));
    const GivenKey* const address = given.find(fmt::format("{}.{}", kSection, kRemoteCache));
    if (address == nullptr) return;
    const auto own = parseHttpUrl((*cache)[kRemoteCache].value_or(std::string())), asked = parseHttpUrl(address->value);
    if (own && asked && *own == *asked) return;
    for (const char* key : {kRemoteUpload, kRemoteCredentials}) cache->erase(key);
}

}  // namespace

template <class Keys>
void describeKeys(Keys& keys, CacheSettings& cache) {
    keys.optional("folder", cache.folder, {.fallback = "the user's cache folder", .option = kSection},
                  "folder that keeps the results of earlier cooks");
    keys.optional(kRemoteCache, cache.remoteCache, {.faultOf = faultOfAddress, .type = "address"},
                  "address of a cache that a team shares over HTTP: results that the cache folder does not have come from there");
    keys.optional(kRemoteUpload, cache.remoteUpload, {}, "also write results into the remote cache");
    keys.optional(kRemoteCredentials, cache.remoteCredentials, {},
                  "file whose first line is 'user:password' or a token for the remote cache (the variable has that line itself)");
}

template <class Keys>
void describeKeys(Keys& keys, UserSettings& settings) {
    keys.section(kSection, settings.cache, {}, [](auto& inner, auto& cache) { describeKeys(inner, cache); });
}

Result<UserSettings> readUserSettings(const GivenKeys& options) {
    constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;
    const std::filesystem::path file = configurationFile();
    std::string text;
    if (std::error_code code; !file.empty() && std::filesystem::exists(file, code)) {
        LC_TRY(found, readTomlText(file, kMostBytes, "settings, which are 2 deep"));
        text = std::move(*found);
    }
    return catchTomlMistakes(file, [&] {
        UserSettings settings;
        GivenKeys given = options;
        addVariables(given, settings.cache);
        toml::table root = toml::parse(text, file.string());
        TomlDocument document{file, root, keyTablesOf<UserSettings>(), "the configuration file", file.parent_path()};
        keepToOwnServer(document, root, given);
        document.given = mergeKeys(root, document.tables, given, document.directory);
        readKeys(document, settings);
        return settings;
    });
}

const KeyTable& cacheKeyTable() {
    return *std::ranges::find(keyTablesOf<UserSettings>(), kSection, &KeyTable::name);
}

std::string optionOf(const KeyRow& row) {
    return optionNamed(row.rule.option.empty() ? std::string_view(row.name) : row.rule.option);
}

std::string variableOf(const KeyRow& row) {
    std::string name = "LIGHTCOOK" + optionOf(row).substr(1);
    std::ranges::transform(name, name.begin(), [](char c) { return c == '-' ? '_' : static_cast<char>(std::toupper(c)); });
    return name;
}

std::string defaultOf(const KeyRow& row) {
    return fmt::format("${}, else the configuration file{}", variableOf(row),
                       row.shape == KeyShape::Flag ? "" : fmt::format(", else {}", row.fallback));
}

}  // namespace lightcook::pipeline
