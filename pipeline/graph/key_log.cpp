#include "pipeline/graph/key_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "pipeline/document/json_difference.h"
#include "pipeline/graph/files.h"

namespace lightcook::pipeline {
namespace {

std::string textOfKeys(const Json& keys) {
    return keys.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Returns a value as one short word.
std::string wordOf(const Json& value) {
    constexpr std::size_t kMost = 40;
    const std::string text = value.is_null() ? "none" : value.dump(-1, ' ', false, Json::error_handler_t::replace);
    return text.size() <= kMost ? text : "...";
}

std::vector<std::string> differences(const Action& action, const Json& before, const Json& now) {
    std::vector<std::string> found;
    if (before.value("tool", Json()) != now["tool"]) found.emplace_back("lightcook is another version");
    eachDifference(before.value("parameters", Json()), now["parameters"], [&](const std::string& path, const Json& was, const Json& is) {
        found.push_back(fmt::format("parameter {}: {} -> {}", path, wordOf(was), wordOf(is)));
    });
    eachDifference(before.value("inputs", Json()), now["inputs"], [&](const std::string& role, const Json& was, const Json& is) {
        const auto file = action.inputs.find(role);
        const std::string name = file == action.inputs.end() ? role : fmt::format("{} ({})", role, file->second.string());
        found.push_back(fmt::format("input {} {}", name, was.is_null() ? "is new" : is.is_null() ? "is gone" : "has changed"));
    });
    const Json upstream = before.value("upstream", Json::array());
    for (std::size_t i = 0; i < action.dependencies.size(); ++i)
        if (i >= upstream.size() || upstream[i] != now["upstream"][i])
            found.push_back(fmt::format("the result of {} has changed", action.dependencies[i]));
    if (upstream.size() > action.dependencies.size()) found.emplace_back("it depends on fewer actions");
    return found;
}

}  // namespace

KeyLog::KeyLog(std::filesystem::path file, Explain explain) : file_(std::move(file)), explain_(std::move(explain)), keys_(Json::object()) {
    const auto text = readFile(file_);
    Json keys = text ? parseJson(*text) : Json();
    if (keys.is_object() && std::all_of(keys.begin(), keys.end(), [](const Json& each) { return each.is_object(); }))
        keys_ = std::move(keys);
}

std::string KeyLog::reason(const Action& action, const Json& key, ResultSource source) const {
    const bool isNew = !keys_.contains(action.id);
    const std::vector<std::string> found = isNew ? std::vector<std::string>() : differences(action, keys_[action.id], key);
    std::string changes = isNew           ? "this folder had no result of it"
                          : found.empty() ? "nothing has changed"
                                          : fmt::format("{}", fmt::join(found, "; "));
    switch (source) {
        case ResultSource::ForcedRun:
            return "--force; " + changes;
        case ResultSource::Run:
            return isNew || !found.empty() ? changes : changes + ", but no cache has its result";
        case ResultSource::LocalCache:
            return isNew || !found.empty() ? "the cache has the result for its inputs; " + changes : changes;
        case ResultSource::RemoteCache:
            return "the remote cache has the result for its inputs; " + changes;
    }
    return changes;
}

void KeyLog::add(const Action& action, Json key, ResultSource source, bool hasResult) {
    std::string why;
    {
        const std::lock_guard lock(mutex_);
        if (explain_) why = reason(action, key, source);
        if (hasResult) keys_[action.id] = std::move(key);
    }
    if (explain_) explain_(action, !isReused(source), why);
}

void KeyLog::save() const {
    const std::lock_guard lock(mutex_);
    const std::string text = textOfKeys(keys_);
    if (const auto held = readFile(file_); !held || *held != text) (void)writeFile(file_, text);
}

}  // namespace lightcook::pipeline
