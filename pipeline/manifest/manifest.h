// cooked.json: everything that an engine and the verifier need to know of a cooked scene. docs/reference/manifest.md lists its fields.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/target.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/document/enum_names.h"
#include "pipeline/graph/action.h"
#include "pipeline/graph/digest.h"
#include "pipeline/manifest/cook_record.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

inline constexpr const char* kManifestName = "cooked.json";
inline constexpr const char* kShaderName = "lightcook.glsl";

/// Meaning of key `partial` of manifest and report.
inline constexpr const char* kPartialCaption =
    "assets of the scene that are not in the folder because `cook --only` left them out; absent if it left out none";

struct Tool {
    std::string name, version;
};
template <class Fields, Is<Tool> Self>
void describe(Fields& fields, Self& tool) {
    fields.required("name", tool.name, "lightcook");
    fields.required("version", tool.version, "version of the program");
}

struct ShaderFile {
    std::string file, digest;
};
template <class Fields, Is<ShaderFile> Self>
void describe(Fields& fields, Self& shader) {
    fields.required("file", shader.file, kFileInFolder, "shader include for the layouts of this scene");
    fields.required("digest", shader.digest, "XXH3-128 of the file");
}

/// A glTF with a light map bound to its nodes.
struct GltfFile {
    std::string file, lightMap, digest;
};
template <class Fields, Is<GltfFile> Self>
void describe(Fields& fields, Self& gltf) {
    fields.required("file", gltf.file, kFileInFolder, "GLB file");
    fields.required("light_map", gltf.lightMap, "light map that it binds");
    fields.required("digest", gltf.digest, "XXH3-128 of the file");
}

struct Manifest {
    int schema = 1;
    std::string scene;
    Tool tool;
    std::string sceneDirectory;
    std::optional<std::string> sceneFile;
    std::string target;
    std::string workingColor;
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;
    UpAxis up = UpAxis::Y;
    ShaderFile shader;
    std::vector<GltfFile> gltf;
    std::optional<std::vector<std::string>> incomplete;
    std::vector<std::string> partial = {};
    bool isPreview = false;
    std::vector<CookedAsset> assets;
    std::vector<CookRecord> cooks = {};
};
template <class Fields, Is<Manifest> Self>
void describe(Fields& fields, Self& manifest) {
    fields.required("schema", manifest.schema, between(1, 1), "version of this form");
    fields.required("scene", manifest.scene, "name of the scene");
    fields.required("tool", manifest.tool, "program that wrote the folder");
    fields.required("scene_directory", manifest.sceneDirectory, "folder of the scene file, relative to this one");
    fields.optional("scene_file", manifest.sceneFile, "name of the scene file; absent if the scene was made of command-line options");
    fields.required("target", manifest.target, "target of the cook: bc, astc or float");
    fields.object("color", "colour of the cooked textures",
                  [&](auto& color) { color.required("working", manifest.workingColor, "working colour space"); });
    fields.presentIf(true, "lobe", manifest.lobe, "specular lobe of cubemaps, tables, dominant lights and shader");
    fields.presentIf(true, "up_axis", manifest.up, "axis of world space that points up");
    fields.required("shader", manifest.shader, "decode and shading, as the verifier ran them");
    fields.presentIf(!manifest.gltf.empty(), "gltf", manifest.gltf, "the scene as glTF: of `cook --gltf`");
    fields.optional("incomplete", manifest.incomplete, "assets that `cook --keep-going` could not cook; absent if the folder is complete");
    fields.presentIf(!manifest.partial.empty(), "partial", manifest.partial, kPartialCaption);
    fields.presentIf(manifest.isPreview, "preview", manifest.isPreview,
                     "true after `cook --preview`: nothing is verified or bounded, and `verify` refuses the folder");
    fields.required("assets", manifest.assets, "assets, in the order of the report");
    fields.required("cooks", manifest.cooks, atLeast(1),
                    "what `verify` plans the assets again from: one cook, or several of which the later ones had `--only`");
}

/// Returns the entry of one asset: the result of its cook action, and the digests of its files and sources.
/// sources          by role
/// sceneDirectory   sources are named relative to it, so that a manifest means the same on another machine
formats::Result<CookedAsset> manifestAsset(const ActionRecord& cooked, const std::map<std::string, std::filesystem::path>& sources,
                                           const std::filesystem::path& sceneDirectory, DigestMemo& digests);

/// Returns the manifest of a cooked scene, without `incomplete`, `partial` and `cooks`.
Manifest makeManifest(const Scene& scene, const std::filesystem::path& outputFolder, std::vector<CookedAsset> assets,
                      std::vector<GltfFile> gltf, const std::string& shaderDigest);

/// Reads cooked.json of a folder, and refuses one of another shape: types, ranges, unknown kinds, files outside the folder.
formats::Result<Manifest> loadManifest(const std::filesystem::path& folder);
/// Returns the same as JSON, for tools that look up single members.
formats::Result<Json> readManifest(const std::filesystem::path& folder);

/// Returns the text of the shader include for the layouts and the lobe of a manifest.
std::string shaderTextOf(const std::vector<CookedAsset>& assets, lighting::SpecularLobe lobe);

/// Return every file that the manifest names, and those of one asset, relative to its folder.
std::vector<FileRecord> filesOf(const Manifest& manifest);
std::vector<FileRecord> filesOf(const CookedAsset& asset);

}  // namespace lightcook::pipeline
