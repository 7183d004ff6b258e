#include "pipeline/command/reference/schemas.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/lut/lut.h"
#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/document/json_schema.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "pipeline/scene/cubemap_layout.h"

namespace lightcook::pipeline {
namespace {

/// The constants of a light map are those of its layout: lists of numbers by name, and the file of a learned layout's tables.
Json lightMapConstants() {
    const Json numbers = {{"type", "array"}, {"items", {{"type", "number"}}}, {"description", "constants of the layout's decode"}};
    const Json tables = {{"type", "object"},
                         {"properties", {{"file", {{"type", "string"}, {"description", "name of the file"}}}}},
                         {"required", {"file"}},
                         {"additionalProperties", false},
                         {"description", "file of texture `tables`"}};
    return {{"type", "object"}, {"properties", {{"tables", tables}}}, {"additionalProperties", numbers}};
}

std::optional<Json> constantsOf(AssetKind kind, SchemaDefinitions& definitions) {
    switch (kind) {
        case AssetKind::LightMap:
            return definitions.add("LightMapConstants", lightMapConstants());
        case AssetKind::Dominant:
            return definitions.add<DominantConstants>();
        case AssetKind::Cubemap:
            return definitions.add<CubemapConstants>();
        case AssetKind::Lut:
            return definitions.add<LutConstants>();
        case AssetKind::Rsrm:
            return definitions.add<RsrmConstants>();
        case AssetKind::Mesh:
            break;
    }
    return std::nullopt;
}

/// Returns the layouts that an asset of a kind may have; empty: any.
std::vector<std::string> layoutsOf(AssetKind kind) {
    if (kind == AssetKind::LightMap) return lightMapLayoutNames();
    if (kind == AssetKind::Cubemap) return formats::namesOf(allCubemapLayouts());
    return {};
}

void addText(const Json& value, const std::string& indent, std::string& text) {
    const bool isObject = value.is_object(), isNested = value.is_structured() && std::ranges::any_of(value, &Json::is_structured);
    if (!isObject && !isNested) {
        std::vector<std::string> names;
        for (const Json& element : value) names.push_back(element.dump());
        text += value.is_array() ? fmt::format("[{}]", fmt::join(names, ", ")) : value.dump();
        return;
    }
    const std::string inner = indent + "  ";
    std::string members;
    for (const auto& [key, member] : value.items()) {
        members += members.empty() ? "\n" : ",\n";
        members += isObject ? fmt::format("{}{}: ", inner, Json(key).dump()) : inner;
        addText(member, inner, members);
    }
    if (!members.empty()) members += "\n" + indent;
    text += isObject ? "{" + members + "}" : "[" + members + "]";
}

}  // namespace

std::string schemaText(const Json& schema) {
    std::string text;
    addText(schema, "", text);
    return text + "\n";
}

Json manifestSchema() {
    SchemaDefinitions definitions;
    Json schema = schemaOf<Manifest>(definitions);
    schema["properties"]["digest"] = {{"type", "string"},
                                      {"description", "XXH3-128 of this file, taken with zeros for the digits of the digest itself"}};
    schema["required"].push_back("digest");
    Json anyConstants = Json::array(), byKind = Json::array();
    for (const AssetKindInfo& kind : allAssetKinds()) {
        Json then = Json::object();
        if (const auto constants = constantsOf(kind.id, definitions)) {
            then["properties"]["constants"] = *constants;
            anyConstants.push_back(*constants);
        }
        if (const auto layouts = layoutsOf(kind.id); !layouts.empty()) then["properties"]["layout"]["enum"] = layouts;
        if (kind.id == AssetKind::Mesh) then["required"] = {"file", "digest"};
        byKind.push_back({{"if", {{"properties", {{"kind", {{"const", std::string(kind.name)}}}}}}}, {"then", std::move(then)}});
    }
    Json all = definitions.all();
    all["CookedTexture"]["properties"]["format"]["enum"] = formats::namesOf(formats::allPixelFormats());
    all["CookedAsset"]["properties"]["constants"]["anyOf"] = anyConstants;
    all["CookedAsset"]["allOf"] = byKind;
    return documentOf("lightcook: cooked.json", schema, all);
}

Json reportSchema() {
    return documentSchema<Report>("lightcook: report.json");
}

}  // namespace lightcook::pipeline
