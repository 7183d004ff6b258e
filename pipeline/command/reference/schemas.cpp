#include "pipeline/command/reference/schemas.h"

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

Json headed(const char* title, const Json& schema) {
    Json headed = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", title}};
    headed.update(schema);
    return headed;
}

/// The constants of a light map are those of its layout: lists of numbers by name, and the file of a learned layout's tables.
Json lightMapConstants() {
    const Json numbers = {{"type", "array"}, {"items", {{"type", "number"}}}};
    const Json tables = {{"type", "object"},
                         {"properties", {{"file", {{"type", "string"}}}}},
                         {"required", {"file"}},
                         {"additionalProperties", false},
                         {"description", "file of texture `tables`"}};
    return {{"type", "object"}, {"properties", {{"tables", tables}}}, {"additionalProperties", numbers}};
}

std::optional<Json> constantsOf(AssetKind kind) {
    switch (kind) {
        case AssetKind::LightMap:
            return lightMapConstants();
        case AssetKind::Dominant:
            return schemaOf<DominantConstants>();
        case AssetKind::Cubemap:
            return schemaOf<CubemapConstants>();
        case AssetKind::Lut:
            return schemaOf<LutConstants>();
        case AssetKind::Rsrm:
            return schemaOf<RsrmConstants>();
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

}  // namespace

std::string manifestSchema() {
    Json schema = schemaOf<Manifest>();
    Json& properties = schema["properties"];
    properties["digest"] = {{"type", "string"}, {"description", "XXH3-128 of this file, with zeros for the digits of the digest itself"}};
    Json& asset = properties["assets"]["items"];
    asset["properties"]["textures"]["items"]["properties"]["format"]["enum"] = formats::namesOf(formats::allPixelFormats());
    asset["allOf"] = Json::array();
    for (const AssetKindInfo& kind : allAssetKinds()) {
        Json then = Json::object();
        if (const auto constants = constantsOf(kind.id)) then["properties"]["constants"] = *constants;
        if (const auto layouts = layoutsOf(kind.id); !layouts.empty()) then["properties"]["layout"]["enum"] = layouts;
        if (kind.id == AssetKind::Mesh) then["required"] = {"file", "digest"};
        asset["allOf"].push_back({{"if", {{"properties", {{"kind", {{"const", std::string(kind.name)}}}}}}}, {"then", std::move(then)}});
    }
    return textOf(headed("lightcook: cooked.json", schema)) + "\n";
}

std::string reportSchema() {
    return textOf(headed("lightcook: report.json", schemaOf<Report>())) + "\n";
}

}  // namespace lightcook::pipeline
