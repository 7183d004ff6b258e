// Assets as the manifest describes them: textures, conventions, constants of the decode, sources.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/api_formats.h"
#include "formats/color.h"
#include "formats/light_map_detail.h"
#include "formats/light_map_layout.h"
#include "formats/probe_place.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/document/enum_names.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

template <class Fields, Is<formats::ColorSpaces> Self>
void describe(Fields& fields, Self& colors) {
    fields.required("source", colors.source, "colour space of the source");
    fields.required("working", colors.working, "colour space of the cooked textures");
}

inline constexpr double kLargestSide = 1 << 20;               ///< of a texture [texels]
inline constexpr double kLargestCount = 4096;                 ///< of views and normals shaded, mips, layers
inline constexpr double kLargestBytes = 1152921504606846976;  ///< 2^60

/// Sampler that a texture was verified with.
struct Sampler {
    std::string filter = "linear";
    std::string wrap = "clamp";
    bool operator==(const Sampler&) const = default;
};
template <class Fields, Is<Sampler> Self>
void describe(Fields& fields, Self& sampler) {
    fields.required("filter", sampler.filter, "linear or trilinear");
    fields.required("wrap", sampler.wrap, "clamp");
}

template <class Fields, Is<formats::ApiFormats> Self>
void describe(Fields& fields, Self& numbers) {
    fields.required("vulkan", numbers.vulkan, "VkFormat");
    fields.optional("dxgi", numbers.dxgi, "DXGI_FORMAT; absent where there is none");
    fields.required("gl", numbers.gl, "sized internal format of OpenGL and OpenGL ES");
    fields.optional("metal", numbers.metal, "MTLPixelFormat; absent where there is none");
}

template <class Fields, Is<formats::ProbePlace> Self>
void describe(Fields& fields, Self& place) {
    fields.optional("position", place.position, "world place of the probe");
    fields.optional("box", place.box, "lowest and highest corner of the room that reflections are corrected for");
    fields.optional("radius", place.radius, between(0, HUGE_VAL), "radius of the sphere that the probe lights");
}

struct CookedTexture {
    std::string role;
    std::string file;
    std::string format;
    int width = 0, height = 0;
    std::optional<formats::ApiFormats> apiFormats;
    int mips = 1, layers = 1, faces = 1;
    std::optional<int> side;  ///< formats::LightMapTextureInfo::side, if it is not 1
    std::optional<bool> isArray;
    std::uint64_t bytesGpu = 0, bytesDisk = 0;
    Sampler sampler;
    std::string digest;  ///< empty until the manifest is put together
};
template <class Fields, Is<CookedTexture> Self>
void describe(Fields& fields, Self& texture) {
    constexpr FieldRule kSide = between(1, kLargestSide), kCount = between(1, kLargestCount), kBytes = between(0, kLargestBytes);
    fields.required("role", texture.role, "name of the texture in the layout, and in the shader: `l0`");
    fields.required("file", texture.file, kFileInFolder, "KTX2 or DDS file");
    fields.required("format", texture.format, "pixel format, as `encode --format` names it");
    fields.optional("api_formats", texture.apiFormats, "the format's number in the graphics APIs");
    fields.required("width", texture.width, kSide, "width [texels]");
    fields.required("height", texture.height, kSide, "height [texels]");
    fields.optional("side", texture.side, kSide,
                    "of the square of the light map's texels that reads one of its texels: texel (x / side, y / side); 1 if absent");
    fields.required("mips", texture.mips, kCount, "number of mip levels; of a light map from level 0 to the last that keeps charts apart");
    fields.required("layers", texture.layers, kCount, "number of array layers");
    fields.optional("array", texture.isArray, "true for an array texture, which a shader samples by layer");
    fields.required("faces", texture.faces, kCount, "6 for a cubemap, else 1");
    fields.required("bytes_gpu", texture.bytesGpu, kBytes, "GPU memory [bytes]");
    fields.required("bytes_disk", texture.bytesDisk, kBytes, "size of the file [bytes]");
    fields.required("sampler", texture.sampler, "sampler that the errors hold for");
    fields.presentIf(!texture.digest.empty(), "digest", texture.digest, "XXH3-128 of the file");
}

/// A file of the user's that an asset was cooked from.
struct SourceFile {
    std::string file, digest;
};
template <class Fields, Is<SourceFile> Self>
void describe(Fields& fields, Self& source) {
    fields.required("file", source.file, "path, relative to `scene_directory`");
    fields.required("digest", source.digest, "XXH3-128 of the file");
}

/// Sources of an asset, and the parameters that they are read with.
struct AssetSource {
    std::optional<Json> description;             ///< of the light map: see LightMapDescription
    std::optional<formats::ColorSpaces> colors;  ///< of an environment or a gradient
    std::optional<bool> repair;
    std::optional<std::string> encoding;
    std::optional<glm::dvec3> axis;
    std::optional<int> zones;
    std::optional<std::map<std::string, SourceFile>> files;  ///< by role; filled in when the manifest is put together
};
template <class Fields, Is<AssetSource> Self>
void describe(Fields& fields, Self& source) {
    fields.optional(
        "description", source.description,
        "conventions of the light map's file: `bake`, `phase`, `frame`, `quantity`, "
        "`light_units`, `encoding` of a picture of 8 or 16 bits, `files` of a bake of listed images, `color_source`, `color_working`, "
        "`firefly_limit`, `repair`");
    fields.optional("colors", source.colors, "colour spaces of an environment or a gradient");
    fields.optional("repair", source.repair, "true if texels that are not finite were replaced");
    fields.optional("encoding", source.encoding, "encoding of a painted gradient: auto, linear or srgb");
    fields.optional("axis", source.axis, "axis that an environment was averaged around");
    fields.optional("zones", source.zones, "zones of that average");
    fields.optional("files", source.files, "files by role: `source`, `mesh`, `sh`, ...");
}

/// Learned bases of a light map, as the vertices of a mesh name them.
struct VertexBasis {
    std::string attribute, lightMap;
};
template <class Fields, Is<VertexBasis> Self>
void describe(Fields& fields, Self& basis) {
    fields.required("attribute", basis.attribute, "vertex attribute with the index of the basis");
    fields.required("light_map", basis.lightMap, "light map that has the bases");
}

/// Quantization of a mesh [bits]; absent members are not quantized.
struct MeshQuantization {
    std::optional<int> positionBits, normalBits, uvBits, lightMapUvBits;
};
template <class Fields, Is<MeshQuantization> Self>
void describe(Fields& fields, Self& bits) {
    constexpr FieldRule kBits = between(0, 32);
    fields.optional("position_bits", bits.positionBits, kBits, "bits of a position's component");
    fields.optional("normal_bits", bits.normalBits, kBits, "bits of an octahedral normal's component");
    fields.optional("uv_bits", bits.uvBits, kBits, "bits of TEXCOORD_0");
    fields.optional("light_map_uv_bits", bits.lightMapUvBits, kBits, "bits of TEXCOORD_1");
}

/// Tiles of a light map in a finer layout (formats/light_map_detail.h).
struct CookedTiles {
    std::string layout;
    std::uint64_t tiles = 0;
    double limit = 0;
    Json constants;
};
template <class Fields, Is<CookedTiles> Self>
void describe(Fields& fields, Self& detail) {
    fields.required("layout", detail.layout,
                    "layout of the tiles: texture `detail_hdr` has `l0` and `light` as layers, `detail_ldr` has `direction` and those of "
                    "`rest`");
    fields.required("tiles", detail.tiles, between(1, formats::kMostDetailTiles),
                    "number of tiles of 8 x 4 texels; the second layer of texture `coverage` says where each lies");
    fields.required("limit", detail.limit, "visible error that 99 % of the samples were to be within");
    fields.required("constants", detail.constants, "constants of the tiles' decode");
}

struct CookedAsset {
    std::string name;
    AssetKind kind = AssetKind::LightMap;
    std::string layout;
    std::optional<std::string> fit;
    int width = 0, height = 0;
    std::optional<double> bitsPerTexel;
    std::optional<std::string> quantity, distribution, normalization, units, phase, frame;
    std::optional<int> decodeDegree;
    std::optional<formats::LightMapFilter> filter;  ///< of a light map
    std::optional<double> key;                      ///< of a light map
    std::optional<std::string> plan;                ///< of a light map: EncodingPlan::digest()
    std::optional<std::string> mipsEnd;             ///< of a light map that was asked for mip levels
    std::optional<bool> dither;
    std::optional<std::string> file;                   ///< of a mesh
    std::optional<std::string> lightMap;               ///< of a mesh or a dominant light
    std::optional<formats::ProbePlace> probe;          ///< of a cubemap
    std::optional<glm::dvec3> axis;                    ///< of a reflection map
    std::optional<std::uint64_t> bytesGpu, bytesDisk;  ///< beside those of the textures
    std::optional<std::uint64_t> vertexBytes;          ///< of a light map whose mesh names its bases; counted there
    std::optional<std::uint64_t> vertices, triangles;
    std::optional<MeshQuantization> quantization;
    std::optional<Json> constants;        ///< of the decode; each kind has a struct for them
    std::optional<std::string> dominant;  ///< of a light map: a name of allDominantLayouts(), where no asset of its own says so
    std::optional<CookedTiles> detail;    ///< of a light map, if some of its tiles have it
    std::vector<CookedTexture> textures;
    AssetSource source;
    std::optional<VertexBasis> basis;
    std::optional<std::string> digest;  ///< of `file`
    std::optional<Json> verify;         ///< parameters of the verify action

    /// Return the GPU memory and the size on disk [bytes] of the textures and of everything beside them.
    std::uint64_t totalBytesGpu() const;
    std::uint64_t totalBytesDisk() const;
};

/// Returns an asset of a kind with the conventions of its row in the table of kinds.
CookedAsset makeCookedAsset(const std::string& name, AssetKind kind, const std::string& layout, int width, int height);

template <class Fields, Is<CookedAsset> Self>
void describe(Fields& fields, Self& asset) {
    constexpr FieldRule kSide = between(0, kLargestSide), kBytes = between(0, kLargestBytes);
    // A mesh has its bytes beside its file, another asset at the end.
    const auto bytes = [&](bool isHere) {
        fields.optionalIf(isHere, "bytes_gpu", asset.bytesGpu, kBytes,
                          "GPU memory beside that of the textures: of a mesh its vertices, of a learned layout its tables [bytes]");
        fields.optionalIf(isHere, "bytes_disk", asset.bytesDisk, kBytes, "bytes on disk beside those of the textures");
    };
    fields.required("name", asset.name, "name of the asset");
    fields.required("kind", asset.kind, "kind of asset");
    fields.required("layout", asset.layout, "layout of the textures");
    fields.optional("fit", asset.fit, "fit of a dominant light");
    fields.required("width", asset.width, kSide, "width [texels], 0 for a mesh");
    fields.required("height", asset.height, kSide, "height [texels], 0 for a mesh");
    fields.optional("bits_per_texel", asset.bitsPerTexel, between(0, 8 * kLargestBytes),
                    "GPU memory of a texel, with tables, and with the index or vertex attribute that names bases [bits]");
    fields.optional("quantity", asset.quantity, "quantity that the decoded texels have");
    fields.optional("distribution", asset.distribution, "microfacet distribution of the tables");
    fields.optional("normalization", asset.normalization, "normalization of the tables: energy or halo3");
    fields.optional("units", asset.units, "units of the light: radiometric");
    fields.optional("phase", asset.phase, "sign convention of the SH basis: none");
    fields.optional("frame", asset.frame, "frame of directions");
    fields.optional("decode_degree", asset.decodeDegree,
                    "degree of the decode as a polynomial of the filtered texels; 0: it is no polynomial");
    fields.optional("filter", asset.filter,
                    "how the light between texels of a light map follows from theirs: `hardware`: the sampler filters texels, the shader "
                    "decodes the result; `decoded`: the shader decodes four texels and mixes the light of those that are covered");
    fields.optional("key", asset.key, between(0, HUGE_VAL),
                    "of a light map: log-average luminance of the exit radiance of white surfaces, which a display is exposed for; an "
                    "exposure of 0.18 / key shows it as middle grey. 0: the map is black");
    fields.optional("plan", asset.plan, "of a light map: digest of the plan that it was encoded with, which `cook --patch` keeps");
    fields.optional("mips_end", asset.mipsEnd, "of a light map with `mips = true`: why its textures have no further mip level");
    fields.optional("dither", asset.dither, "true if the codes of a reflection map are dithered");
    fields.optional("light_map", asset.lightMap, "light map that a mesh is lit by, or that a dominant light belongs to");
    fields.optional("probe", asset.probe, "place of a cubemap's probe, as far as the scene states it");
    fields.optional("axis", asset.axis, "world direction that the first column of a reflection map looks in; unit");
    fields.optional("file", asset.file, kFileInFolder, "glTF file of a mesh");
    bytes(asset.file.has_value());
    fields.optional("vertex_bytes_gpu", asset.vertexBytes, kBytes,
                    "GPU memory of the vertex attribute that names a learned layout's bases, which counts in the mesh [bytes]");
    fields.optional("vertices", asset.vertices, "number of vertices");
    fields.optional("triangles", asset.triangles, "number of triangles");
    fields.optional("quantization", asset.quantization, "quantization of a mesh [bits]");
    fields.optional("constants", asset.constants, "constants of the shader's decode");
    fields.optional("dominant", asset.dominant,
                    "of a light map: `derived` where the shader takes the dominant light from its coefficients (`lcDerivedLight`)");
    fields.optional("detail", asset.detail, "tiles of a light map that are stored once more, in a finer layout: the shader takes those");
    fields.required("textures", asset.textures, "textures of the layout");
    fields.required("source", asset.source, "sources, and how they are read");
    bytes(!asset.file.has_value());
    fields.optional("basis", asset.basis, "learned bases that the vertices of a mesh name");
    fields.optional("digest", asset.digest, "XXH3-128 of `file`");
    fields.optional("verify", asset.verify, "parameters of the verification: `max_error`, `shading`, `samples`");
}

}  // namespace lightcook::pipeline
