#include "tests/formats/fuzz/targets.h"

#include <array>

#include "formats/environment.h"
#include "formats/gltf_scene.h"
#include "formats/gpu_texture.h"
#include "formats/image/bmp.h"
#include "formats/image/radiance_file.h"
#include "formats/lmbake.h"
#include "formats/plain_image.h"
#include "tests/formats/temporary_folder.h"
#include "tests/formats/texture_fixture.h"

namespace lightcook::formats {
namespace {

/// Larger textures are what a header alone can claim, and reading them is no other code.
constexpr std::size_t kMostTextureBytes = std::size_t{1} << 22;

void readTexture(const std::filesystem::path& file) {
    (void)containerOfContent(file);
    const Result<TextureReader> texture = TextureReader::open(file);
    if (!texture || texture->shape().gpuBytes() > kMostTextureBytes) return;
    (void)texture->metadata();
    (void)texture->hasOwnTransfer();
    (void)texture->hasBc1Alpha();
    for (const SubImage& image : allImages(texture->shape())) (void)texture->readImage(image);
}

void readRadiance(const std::filesystem::path& file) {
    (void)radianceFactors(file);
    (void)radianceChromaticities(file);
    (void)readRadiancePicture(file);
}

void readBitmap(const std::filesystem::path& file) {
    (void)readMaskedBmp(file);
}

void readPicture(const std::filesystem::path& file) {
    (void)readImage(file);
}

void readGltf(const std::filesystem::path& file) {
    (void)gltfFilesBeside(file);
    (void)checkLightMapUvs(file);
    const Result<GltfScene> scene = GltfScene::load(file);
    if (!scene) return;
    (void)scene->hasLightMapUvs();
    (void)scene->mostDrawn();
    for (const GltfScene::Placed& placed : scene->placedMeshes()) (void)placed.mesh->vertexCount();
    (void)scene->writePlain(file.parent_path() / "written.glb", nullptr);
}

void readPlaces(const std::filesystem::path& file) {
    (void)readLmbake(file);
}

void readProbes(const std::filesystem::path& file) {
    (void)loadProbeSh(file, "probe0.exr");
    (void)loadProbePosition(file, "probe0.exr");
}

constexpr std::array kTargets = {FuzzTarget{"texture", ".ktx2", readTexture}, FuzzTarget{"radiance", ".hdr", readRadiance},
                                 FuzzTarget{"bitmap", ".bmp", readBitmap},    FuzzTarget{"png", ".png", readPicture},
                                 FuzzTarget{"gltf", ".glb", readGltf},        FuzzTarget{"lmbake", ".lmbake", readPlaces},
                                 FuzzTarget{"probes", ".json", readProbes}};

}  // namespace

std::span<const FuzzTarget> fuzzTargets() {
    return kTargets;
}

void readAsFile(const FuzzTarget& target, std::span<const std::byte> bytes) {
    static const TemporaryFolder folder;
    const std::filesystem::path file = folder / (std::string("input") + std::string(target.extension));
    putFile(file, bytes);
    target.read(file);
}

}  // namespace lightcook::formats
