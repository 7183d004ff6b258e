#include "pipeline/repack/packed_light_map.h"

#include "formats/epic_light_maps.h"
#include "formats/gltf_scene.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/light_map/chart_places.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/note_keys.h"
#include "pipeline/assets/results.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/repack/repack.h"

namespace lightcook::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::ErrorCode;
using formats::Result;

ChartPacking packingOf(const Repacked& made, double maxVisible) {
    ChartPacking packing;
    packing.maxVisible = maxVisible;
    packing.widthBefore = made.sizeBefore.x;
    packing.heightBefore = made.sizeBefore.y;
    packing.width = made.size.x;
    packing.height = made.size.y;
    packing.readBefore = made.readBefore;
    packing.read = made.read;
    packing.charts = static_cast<std::int64_t>(made.charts);
    packing.reducedCharts = static_cast<std::int64_t>(made.reducedCharts);
    packing.relRms = made.relRms;
    packing.visible = made.visible.p99;
    packing.uvBefore = made.uvBefore;
    return packing;
}

/// Returns how a bake that LightMapWriter wrote is read. Its texels were checked when they were read first.
formats::LightMapDescription writtenDescription(const formats::LightMapDescription& source) {
    formats::LightMapDescription description;
    description.bake = "sh9";
    description.colors = source.colors;
    description.colors.source = source.colors.working;
    description.fireflyLimit = 0;
    return description;
}

/// Returns what to do about a mesh that does not belong to its light map, or has no charts that could be packed.
std::string meshAdvice(const fs::path& mesh) {
    const auto scene = formats::GltfScene::load(mesh);
    if (!scene || scene->triangleMeshes().empty()) return "";
    if (scene->hasLightMapUvs()) return "; --charts keep cooks it without packing";
    return " on all triangles, with --charts keep too: unwrap these as well, or put what no light map lies on into a mesh of its own";
}

}  // namespace

Action packAction(const LightMapEntry& entry, double maxVisible, bool repair) {
    PackParameters parameters{entry.description, maxVisible};
    parameters.description.repair = repair;
    RoleFiles inputs = bakeInputs(entry.file, entry.description);
    inputs.merge(meshInputs(kMeshRole, *entry.mesh, entry.description.lmbake));
    return {actionId(ActionStep::Pack, entry.name), kPackChartsKind, entry.name, toJson(parameters), std::move(inputs), {}};
}

Result<ActionOutcome> packCharts(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<PackParameters>(context));
    const auto& inputs = context.action.inputs;
    LC_CHECK(formats::checkEpicUvs(inputs.at(kSourceRole), inputs.at(kMeshRole), parameters->description.image));
    RepackRequest request;
    request.map = inputs.at(kSourceRole);
    request.description = withFiles(parameters->description, inputs);
    request.meshes = {inputs.at(kMeshRole)};
    request.lmbake = lmbakeOf(inputs, kMeshRole);
    request.folder = context.folder / context.action.asset;
    request.maxVisible = parameters->maxVisible;
    auto made = repack(request, context.state, &context.action);
    if (!made) {
        formats::Error error = made.error();
        if (error.code == ErrorCode::WrongShape && error.file == request.meshes.front()) error.detail += meshAdvice(request.meshes.front());
        return tl::make_unexpected(error);
    }
    PackResult result{packingOf(*made, parameters->maxVisible), numbersOf(made->places), {}, {}, Json::object()};
    result.map = context.action.asset + "/" + made->map.filename().string();
    result.mesh = context.action.asset + "/" + made->meshes.front().filename().string();
    result.notes = {{note_keys::kRepairedNotFinite, made->repairs.notFinite},
                    {note_keys::kRepairedNegativeDc, made->repairs.negativeDc},
                    {note_keys::kRepairedBands, made->repairs.bandsBeyond},
                    {note_keys::kRepairedFireflies, made->repairs.fireflies},
                    {note_keys::kNegativeAfterGamut, made->negativeAfterGamut}};
    return outcomeWith(result, {result.map, result.mesh});
}

Result<PackedLightMap> packedLightMap(const Action& action, const ActionRecord& record, const fs::path& folder) {
    LC_TRY(parameters, fromJson<PackParameters>(action.parameters, action.id + ", parameters"));
    LC_TRY(result, fromJson<PackResult>(record.result, action.id));
    PackedLightMap packed;
    packed.sources = action.inputs;
    packed.files = {{kSourceRole, folder / result->map}, {kMeshRole, folder / result->mesh}};
    for (const auto& input : action.inputs)
        if (isColorConfigRole(input.first)) packed.files.insert(input);
    packed.bake = {parameters->description, result->packing, result->places};
    packed.packed = writtenDescription(withFiles(parameters->description, action.inputs));
    packed.notes = result->notes;
    return packed;
}

LightMapEntry packedEntry(LightMapEntry entry, const PackedLightMap& packed) {
    entry.file = packed.files.at(kSourceRole);
    entry.mesh = packed.files.at(kMeshRole);
    entry.description = packed.packed;
    return entry;
}

RoleFiles unpackedInputs(const PackedLightMap& packed) {
    RoleFiles inputs;
    for (const auto& [role, file] : packed.sources) {
        if (role.starts_with(kSourceRole)) inputs[kUnpackedRole + role.substr(kSourceRole.size())] = file;
        if (role.starts_with(kMeshRole)) inputs[kUnpackedMeshRole + role.substr(std::string(kMeshRole).size())] = file;
        // These inputs belong to the bake as it was: the packed one reads no mesh.
        if (role.starts_with(kFramesRole) || role == kLmbakeRole) inputs[role] = file;
    }
    return inputs;
}

}  // namespace lightcook::pipeline
