// Parts of a report, by name.
#pragma once

#include <stdexcept>
#include <string>

#include "pipeline/document/json.h"

namespace lightcook::pipeline {

/// Returns an asset of a report or a manifest, or a null pointer without it.
inline const Json* findAsset(const Json& document, const std::string& name) {
    for (const Json& asset : document.at("assets"))
        if (asset.at("name") == name) return &asset;
    return nullptr;
}
inline bool hasAsset(const Json& document, const std::string& name) {
    return findAsset(document, name) != nullptr;
}
/// Returns an asset of a report or a manifest; throws without it.
inline const Json& assetOf(const Json& document, const std::string& name) {
    const Json* asset = findAsset(document, name);
    if (asset == nullptr) throw std::runtime_error("no asset " + name);
    return *asset;
}

/// Returns the first entry of `skipped` whose `what` contains the words, or null without one.
inline Json skipOf(const Json& report, const std::string& what) {
    for (const Json& skip : report.at("skipped"))
        if (skip.at("what").get<std::string>().find(what) != std::string::npos) return skip;
    return nullptr;
}

}  // namespace lightcook::pipeline
