#include <array>

#include "formats/chart_clusters.h"
#include "formats/environment.h"
#include "formats/epic_light_maps.h"
#include "formats/gltf/triangle_mesh.h"
#include "formats/gltf_light_map.h"
#include "formats/gltf_scene.h"
#include "formats/gpu_texture.h"
#include "formats/image/bmp.h"
#include "formats/image/radiance_file.h"
#include "formats/lmbake.h"
#include "formats/plain_image.h"
#include "formats/probe_place.h"
#include "tests/formats/fuzz/written_bake.h"
#include "tests/formats/texture_fixture.h"
#include "tests/fuzz/target.h"

namespace lightcook::formats {
namespace {

using fuzz::asFile, fuzz::Bytes;

/// Larger textures are what a header alone can claim, and reading them is no other code.
constexpr std::size_t kMostTextureBytes = std::size_t{1} << 22;

void readTexture(Bytes bytes) {
    const std::filesystem::path file = asFile("input.ktx2", bytes);
    (void)containerOfContent(file);
    const Result<TextureReader> texture = TextureReader::open(file);
    if (!texture || texture->shape().gpuBytes() > kMostTextureBytes) return;
    (void)texture->metadata();
    (void)texture->hasOwnTransfer();
    (void)texture->hasBc1Alpha();
    for (const SubImage& image : allImages(texture->shape())) (void)texture->readImage(image);
}

void readRadiance(Bytes bytes) {
    const std::filesystem::path file = asFile("input.hdr", bytes);
    (void)radianceFactors(file);
    (void)radianceChromaticities(file);
    (void)readRadiancePicture(file);
}

void readBitmap(Bytes bytes) {
    const std::filesystem::path file = asFile("input.bmp", bytes);
    (void)readMaskedBmp(file);
}

void readPicture(Bytes bytes) {
    const std::filesystem::path file = asFile("input.png", bytes);
    (void)readImage(file);
}

void readMap(const LightMapReader& reader) {
    for (int y = 0; y < reader.height(); y += 2) (void)reader.read(y, std::min(2, reader.height() - y));
    (void)reader.placeOf(0, 1, 0, 0);
}

/// Reads what lies in a scene beside its triangles: light maps of Unreal, bindings of ours, places of nodes.
void readGltfLight(const std::filesystem::path& file) {
    (void)checkLightMapUvs(file);
    (void)checkAllLightMapUvs(file, {{"Square"}});
    (void)boundLightMaps(file);
    (void)wrongBinding(file);
    (void)GltfScene::load(file, {}, {{"Square", {0.5, 0.5}, {0.25, 0.25}}});
    (void)epicFilesBeside(file);
    const auto images = epicImageNames(file);
    LightMapDescription description;
    description.bake = "unreal-hq";
    if (images && images->size() > 1) description.image = images->back();
    (void)checkEpicUvs(file, file, description.image);
    if (const auto reader = LightMapReader::open(file, description)) readMap(*reader);
}

void readGltf(Bytes bytes) {
    const std::filesystem::path file = asFile("input.glb", bytes);
    (void)gltfFilesBeside(file);
    readGltfLight(file);
    const Result<GltfScene> scene = GltfScene::load(file);
    if (!scene) return;
    (void)scene->hasLightMapUvs();
    (void)scene->mostDrawn();
    for (const GltfScene::Placed& placed : scene->placedMeshes()) (void)placed.mesh->vertexCount();
    constexpr int kSide = 16;
    const auto meshes = scene->triangleMeshes();
    (void)islandRuns(meshes, kSide, kSide);
    const ClusterMap clusters{kSide, kSide, std::vector<std::uint8_t>(kSide * kSide / (kClusterBlock * kClusterBlock))};
    (void)scene->writePlain(file.parent_path() / "written.glb", nullptr);
    (void)scene->writePlain(file.parent_path() / "written.glb", &clusters);
    std::vector<std::vector<glm::vec2>> uvs;
    for (const TriangleMesh* mesh : meshes) uvs.emplace_back(mesh->vertexCount(), glm::vec2(0.5f));
    (void)scene->writeLightMapUvs(file.parent_path() / "written.glb", uvs);
}

void readPlaces(Bytes bytes) {
    const std::filesystem::path file = asFile("input.lmbake", bytes);
    (void)readLmbake(file);
}

void readProbes(Bytes bytes) {
    const std::filesystem::path file = asFile("input.json", bytes);
    (void)loadProbeSh(file, "probe0.exr");
    (void)loadProbePlace(file, "probe0.exr");
}

void readBake(Bytes bytes) {
    const WrittenBake bake = writeBake(fuzz::textOf(bytes));
    (void)nameOfBake(bake.file, bake.description.bake);
    (void)bakeFilesBeside(bake.file, bake.description.bake);
    (void)faultOfPictureSet(bake.file, bake.description.bake);
    (void)lmbakeBeside(bake.file, bake.description.bake);
    (void)lmbakeOfImport(bake.file);
    (void)lmbakeOfSplitBake(bake.file);
    const std::filesystem::path leading = leadingFile(bake.file, bake.description.bake);
    (void)LightMapReader::recognize(leading, bake.description);
    const Result<LightMapReader> reader = LightMapReader::open(leading, bake.description);
    if (reader) readMap(*reader);
}

constexpr std::array kFuzzTargets = {
    fuzz::Target{"texture", readTexture}, fuzz::Target{"radiance", readRadiance}, fuzz::Target{"bitmap", readBitmap},
    fuzz::Target{"png", readPicture},     fuzz::Target{"gltf", readGltf},         fuzz::Target{"lmbake", readPlaces},
    fuzz::Target{"probes", readProbes},   fuzz::Target{"bake", readBake},
};

}  // namespace
}  // namespace lightcook::formats

std::span<const lightcook::fuzz::Target> lightcook::fuzz::targets() {
    return formats::kFuzzTargets;
}
