// Merges what the command line gives over a TOML document, and converts documents to JSON and back, in which they are stored.
#pragma once

#include <toml++/toml.h>
#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "pipeline/document/given_keys.h"
#include "pipeline/document/json.h"
#include "pipeline/document/keys.h"

namespace lightcook::pipeline {

/// The values that options gave, with these options.
using GivenNodes = std::map<const toml::node*, std::string>;

/// Sets the given keys in a document, in every table that their name means; an array of tables that is missing gets one table. Removes the
/// keys that go before a given one (KeyRule::of). Returns the new values.
/// tables     of the document
/// directory  that paths of the document are relative to; those of options are relative to the current folder
GivenNodes mergeKeys(toml::table& root, std::span<const KeyTable> tables, const GivenKeys& given, const std::filesystem::path& directory);

/// Returns the row of a key such as "output.target"; nullptr for others.
const KeyRow* keyRowOf(std::span<const KeyTable> tables, std::string_view key);

/// Returns a document as JSON: tables, lists, texts, numbers and booleans.
Json jsonOfToml(const toml::node& node);
/// Returns the document of which jsonOfToml makes some JSON.
toml::table tomlOfJson(const Json& document);

/// Returns a value as an option would give it.
std::string optionTextOf(const toml::node& node);

}  // namespace lightcook::pipeline
