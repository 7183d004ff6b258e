#include "pipeline/command/info.h"

#include <fmt/format.h>
#include <glob.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>

#include "formats/bake_format.h"
#include "formats/epic_light_maps.h"
#include "formats/gltf_light_map.h"
#include "formats/gltf_scene.h"
#include "formats/light_map.h"
#include "formats/lmbake.h"
#include "formats/lower_extension.h"
#include "formats/plain_image.h"
#include "pipeline/assets/light_map/bake_reading.h"
#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/printing.h"
#include "pipeline/command/texture_file.h"
#include "pipeline/cook/integrity.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"
#include "pipeline/scene/scene.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

Json describeTexture(const formats::TextureReader& texture) {
    const formats::TextureShape& shape = texture.shape();
    return {{"container", texture.container() == formats::Container::Dds ? "dds" : "ktx2"},
            {"format", std::string(formats::info(shape.format).name)},
            {"width", shape.width},
            {"height", shape.height},
            {"mips", shape.mipCount},
            {"layers", shape.layerCount},
            {"faces", shape.faceCount},
            {"zstd", texture.isZstd()},
            {"bytes_gpu", shape.gpuBytes()},
            {"bytes_disk", texture.fileBytes()},
            {"metadata", texture.metadata()}};
}

Json describeImage(const formats::PlainImage& image) {
    const float infinity = std::numeric_limits<float>::infinity();
    float low = infinity, high = -infinity;
    std::int64_t notFinite = 0, negative = 0;
    const int colours = std::clamp(image.channelCount - (image.hasAlpha ? 1 : 0), 0, 3);
    for (const glm::vec4& texel : image.texels.texels())
        for (int c = 0; c < 4; ++c) {
            if (c == 3 ? !image.hasAlpha : c >= colours) continue;
            if (!std::isfinite(texel[c])) {
                ++notFinite;
                continue;
            }
            low = std::min(low, texel[c]);
            high = std::max(high, texel[c]);
            negative += texel[c] < 0 ? 1 : 0;
        }
    Json json = {{"width", image.texels.width()},
                 {"height", image.texels.height()},
                 {"channels", image.channelCount},
                 {"minimum", low},
                 {"maximum", high},
                 {"not_finite", notFinite},
                 {"negative", negative}};
    if (!image.ignored.empty()) json["ignored_channels"] = image.ignored;
    if (image.chromaticities) json["chromaticities"] = *image.chromaticities;
    if (image.environment) json["envmap"] = *image.environment == formats::ExrEnvironment::Cube ? "cube" : "latlong";
    return json;
}

/// Describes an image, or the channels of an OpenEXR file that are those of no image.
Result<Json> describeAnyImage(const std::filesystem::path& file) {
    const auto image = formats::readImage(file);
    if (image) return describeImage(*image);
    if (image.error().code == formats::ErrorCode::WrongShape)
        if (const auto content = formats::exrContent(file))
            return Json{{"width", content->width},
                        {"height", content->height},
                        {"channels", content->channels.size()},
                        {"channel_names", content->channels}};
    return tl::make_unexpected(image.error());
}

/// Describes a light map: how it was recognised, and its shape.
Json describeLightMap(const formats::LightMapReader& map) {
    const BakeReading reading = readingOf(map);
    Json json = {{"light_map", reading.bake},   {"evidence", reading.evidence},
                 {"assumed", reading.assumed},  {"other_readings", reading.otherReadings},
                 {"width", map.width()},        {"height", map.height()},
                 {"normals", map.hasNormals()}, {"coverage", map.hasCoverage()}};
    if (!reading.incompleteSets.empty()) json["incomplete_sets"] = reading.incompleteSets;
    return json;
}

/// Describes a light map that cannot be opened without its mesh.
Json describeWithoutMesh(const formats::BakeRecognition& recognition, const formats::Error& error) {
    const BakeReading reading = readingOf(recognition);
    return {{"light_map", reading.bake},
            {"evidence", reading.evidence},
            {"assumed", reading.assumed},
            {"other_readings", reading.otherReadings},
            {"needs", error.line()}};
}

/// Returns true for a picture whose name, and the files beside it, make it a part of a bake of several files.
bool isPartOfSet(const std::filesystem::path& file) {
    return formats::leadingFile(file, formats::kAutoBake) != file || !formats::faultOfPictureSet(file, formats::kAutoBake).empty();
}

/// Describes where the meshes of a bake of Godot lie.
Json describeLmbake(const formats::Lmbake& lmbake) {
    Json json = {{"slices", lmbake.sliceCount()}, {"meshes", Json::array()}};
    for (const formats::LmbakeUser& user : lmbake.users) {
        const glm::dvec4& at = user.rectangle;
        json["meshes"].push_back({{"node", user.name()}, {"slice", user.slice}, {"rectangle", {at.x, at.y, at.z, at.w}}});
    }
    return json;
}

/// Describes how the nodes of a glTF are found in the lmbake of the same name; null without one.
Json describePlaces(const std::filesystem::path& file) {
    std::filesystem::path lmbake = file;
    lmbake.replace_extension(".lmbake");
    std::error_code code;
    if (!std::filesystem::is_regular_file(lmbake, code)) return {};
    const auto scene = formats::GltfScene::load(file, lmbake);
    if (!scene) return {{"file", lmbake.string()}, {"error", scene.error().line()}};
    const formats::LmbakeMatch& match = *scene->lmbakeMatch();
    return {{"file", lmbake.string()},
            {"nodes_with_rectangle", match.placed},
            {"nodes_without_rectangle", match.unplaced},
            {"rectangles_without_node", match.unread}};
}

/// Describes the light maps of Unreal that a glTF holds, each by its image. One that cannot be read has its error.
Result<Json> describeEpicMaps(const std::filesystem::path& file) {
    LC_TRY(images, formats::epicImageNames(file));
    Json list = Json::array();
    for (const std::string& image : *images) {
        formats::LightMapDescription description;
        description.image = image;
        Json entry = {{"image", image}};
        if (const auto map = formats::LightMapReader::open(file, description))
            entry.update(describeLightMap(*map));
        else
            entry["error"] = map.error().line();
        list.push_back(std::move(entry));
    }
    return list;
}

Json describeScene(const Scene& scene) {
    Json json = {{"scene", scene.name},
                 {"target", std::string(formats::info(scene.output.target).name)},
                 {"light_map_layout", layoutAsked(scene.output)},
                 {"max_error", errorLimit(scene.output)}};
    if (const auto limit = visibleLimit(scene.output, LightMapEntry{})) json["max_visible"] = *limit;
    for (const auto& entry : scene.lightMaps) json["light_maps"].push_back(entry.name);
    for (const auto& entry : scene.probes) json["probes"].push_back(entry.name);
    for (const auto& entry : scene.gradients) json["gradients"].push_back(entry.name);
    return json;
}

/// Returns the first of the scenes of a file, with the names of their targets.
Json describeScenes(const std::vector<Scene>& scenes) {
    Json json = describeScene(scenes.front());
    if (!scenes.front().isOfTargets) return json;
    json.erase("target");
    for (const Scene& scene : scenes) json["targets"].push_back(formats::info(scene.output.target).name);
    return json;
}

/// Returns the figures of a whole asset under one kind of shading: rel_rms, null for light that the asset does not have, and visible errors
/// where some were measured.
Json describeErrors(const std::vector<verify::StageError>& stages, verify::ErrorFigures verify::StageError::*shading) {
    const verify::ErrorFigures& figures = stages.back().*shading;
    Json json = {{"rel_rms", hasShading(stages, shading) ? Json(figures.relRms) : Json()}};
    if (!figures.visible) return json;
    json["visible_p99"] = figures.visible->p99;
    if (figures.visible->bound) json["visible_bound"] = *figures.visible->bound;
    return json;
}

/// row  of the folder's report; null: it has none of this asset
Json describeAsset(const CookedAsset& asset, const ReportRow* row) {
    Json json = {{"name", asset.name}, {"kind", std::string(info(asset.kind).name)}, {"layout", asset.layout}};
    if (asset.file) json["file"] = *asset.file;
    if (asset.width > 0 && asset.height > 0) json.update({{"width", asset.width}, {"height", asset.height}});
    if (asset.vertices) json["vertices"] = *asset.vertices;
    if (asset.triangles) json["triangles"] = *asset.triangles;
    if (!asset.textures.empty()) json["textures"] = asset.textures.size();
    json.update({{"bytes_gpu", asset.totalBytesGpu()}, {"bytes_disk", asset.totalBytesDisk()}});
    if (row == nullptr || row->verdict.stages.empty()) return json;
    const std::vector<verify::StageError>& stages = row->verdict.stages;
    json.update({{"passed", row->verdict.passed},
                 {"diffuse", describeErrors(stages, &verify::StageError::diffuse)},
                 {"specular", describeErrors(stages, &verify::StageError::specular)}});
    return json;
}

/// Returns the assets of a cooked folder, with what its report says of them where it has one.
Result<Json> describeFolder(const std::filesystem::path& folder, const Manifest& manifest) {
    Result<Report> report;
    std::error_code code;
    const std::filesystem::path file = folder / kReportName;
    if (std::filesystem::exists(file, code)) report = loadReport(file);
    if (!report) return tl::make_unexpected(report.error());
    Json json = {{"scene", manifest.scene}, {"tool", toJson(manifest.tool)}, {"target", manifest.target}, {"assets", Json::array()}};
    for (const CookedAsset& asset : manifest.assets) {
        const auto row = std::ranges::find(report->assets, asset.name, &ReportRow::name);
        json["assets"].push_back(describeAsset(asset, row == report->assets.end() ? nullptr : &*row));
    }
    return json;
}

/// Returns name, layout, size, textures and proof of the light maps that a glTF binds.
Json briefly(const Json& maps) {
    Json list = Json::array();
    for (const Json& map : maps) {
        if (!map.is_object()) continue;
        Json facts = Json::object();
        for (const char* key : {"name", "layout", "width", "height", "bound"})
            if (map.contains(key)) facts[key] = map[key];
        if (const Json textures = map.value("textures", Json()); textures.is_array())
            for (const Json& texture : textures)
                if (texture.is_object()) facts["textures"].push_back(texture.value("uri", Json()));
        list.push_back(std::move(facts));
    }
    return list;
}

}  // namespace

Result<Json> describeFile(const std::filesystem::path& file) {
    std::error_code code;
    if (std::filesystem::is_directory(file, code))
        return loadManifest(file).and_then([&](const Manifest& manifest) { return describeFolder(file, manifest); });
    const std::string extension = formats::lowerExtension(file);
    if (isTextureFile(file)) return formats::TextureReader::open(file).map(describeTexture);
    if (extension == ".toml") return readScenes(file).map(describeScenes);
    if (file.filename() == kManifestName || file.filename() == kReportName)
        return formats::failure(formats::ErrorCode::FileUnreadable, file,
                                fmt::format("found a file of a cooked scene, expected its folder: {}",
                                            file.has_parent_path() ? file.parent_path().string() : "."));
    if (extension == ".glb" || extension == ".gltf") {
        auto facts = formats::GltfScene::load(file).map([](const formats::GltfScene& scene) {
            Json json = {
                {"vertices", scene.vertexCount()}, {"triangles", scene.triangleCount()}, {"light_map_uvs", scene.hasLightMapUvs()}};
            for (const auto& material : scene.materials()) json["materials"].push_back(material.name);
            return json;
        });
        if (!facts) return facts;
        LC_TRY(bound, formats::boundLightMaps(file));
        if (const Json maps = parseJson(*bound); maps.is_array() && !maps.empty()) (*facts)["light_maps"] = briefly(maps);
        if (Json places = describePlaces(file); !places.is_null()) (*facts)["lmbake"] = std::move(places);
        LC_TRY(baked, describeEpicMaps(file));
        if (!baked->empty()) (*facts)["as_light_maps"] = *baked;
        return facts;
    }
    if (formats::isLmbakeFile(file)) return formats::readLmbake(file).map(describeLmbake);
    if (extension == ".exr" || extension == ".hdr" || isPartOfSet(file)) {
        const auto map = formats::LightMapReader::open(file, {});
        if (!map)
            if (const auto known = formats::LightMapReader::recognize(file, {}); known && known->format->needsMesh())
                return describeWithoutMesh(*known, map.error());
        if (map && map->recognition().isCertain) return describeLightMap(*map);
        return describeAnyImage(file).map([&](Json json) {
            if (map)
                json["as_light_map"] = describeLightMap(*map);
            else if (map.error().code != formats::ErrorCode::UnknownBake)
                json["as_light_map"] = {{"error", map.error().line()}};
            return json;
        });
    }
    return describeAnyImage(file);
}

Result<std::vector<std::filesystem::path>> expandPatterns(const std::vector<std::string>& names) {
    std::vector<std::filesystem::path> files;
    for (const std::string& name : names) {
        std::error_code code;
        if (name.find_first_of("*?[") == std::string::npos || std::filesystem::exists(name, code)) {
            files.emplace_back(name);
            continue;
        }
        glob_t found{};
        const int outcome = ::glob(name.c_str(), 0, nullptr, &found);
        for (std::size_t i = 0; outcome == 0 && i < found.gl_pathc; ++i) files.emplace_back(found.gl_pathv[i]);
        ::globfree(&found);
        if (outcome != 0)
            return formats::failure(formats::ErrorCode::FileUnreadable, name, "found no file of this pattern, expected at least one");
    }
    return files;
}

namespace {

/// Describes a file or a cooked folder.
/// changed  gets an error for each file of a folder that is not the one that was cooked
Result<Json> describeAndCheck(const std::filesystem::path& file, std::vector<formats::Error>& changed) {
    std::error_code code;
    if (!std::filesystem::is_directory(file, code)) return describeFile(file);
    LC_TRY(manifest, loadManifest(file));
    auto facts = describeFolder(file, *manifest);
    if (facts) changed = checkDigests(file, *manifest);
    return facts;
}

/// Describes every file. One that cannot be read does not keep the others from being described. A cooked folder with files that were
/// changed is described too, and fails.
int runInfo(const std::vector<std::string>& names, const JsonOutput& json, Session& session) {
    json.prepare(session);
    const auto files = expandPatterns(names);
    if (!files) return json.finish(session, {}, {files.error()});
    if (auto checked = session.paths.checkAgainst(*files, "a file of the pattern"); !checked) return session.finish(checked);
    for (const std::filesystem::path& file : *files) {
        if (!session.paths.hasOutputs() || formats::lowerExtension(file) != ".toml") continue;
        const auto scene = readScene(file);
        if (!scene) continue;  // its description says why
        if (auto checked = session.paths.checkAgainstScene(*scene, {}); !checked) return session.finish(checked);
    }
    Json all = Json::array();
    std::vector<formats::Error> errors;
    for (const std::filesystem::path& file : *files) {
        std::vector<formats::Error> changed;
        const auto facts = describeAndCheck(file, changed);
        if (!facts) {
            errors.push_back(facts.error());
            continue;
        }
        std::ranges::move(changed, std::back_inserter(errors));
        Json entry = *facts;
        if (files->size() > 1) {
            entry = {{"file", file.string()}};
            entry.update(*facts);
        }
        if (!json.isStandardOutput()) {
            if (files->size() > 1) session.terminal.say(StyledLine{{Style::Faint, file.string() + ":"}});
            printJson(session.terminal, *facts, files->size() > 1 ? "  " : "");
        }
        all.push_back(std::move(entry));
    }
    if (files->size() > 1) return json.finish(session, all, errors);
    return json.finish(session, all.empty() ? Json() : all[0], errors);
}

}  // namespace

CommandFunction defineInfo(CLI::App& app) {
    struct Options {
        std::vector<std::string> files;
        JsonOutput json;
    };
    const auto options = std::make_shared<Options>();
    app.add_option(
           "files", options->files,
           "Textures, images, light maps, meshes, lmbakes of Godot, scene files, output folders of cook, or patterns such as '*.ktx2'")
        ->required()
        ->type_name(kFilePlaceholder);
    options->json.add(app, "the contents (of several files a list)");
    app.footer("A file of a cooked folder that is not the one that was cooked is an error: exit code 4.");
    return [options](Session& session) { return runInfo(options->files, options->json, session); };
}

}  // namespace lightcook::pipeline
