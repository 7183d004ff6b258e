#include "formats/gltf_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "formats/chart_clusters.h"
#include "formats/file/one_line.h"
#include "formats/gltf/draco_mesh.h"
#include "formats/gltf/gltf_document.h"
#include "formats/gltf/material_needs.h"
#include "formats/gltf/triangle_mesh.h"
#include "formats/pending_file.h"

namespace lightcook::formats {
namespace {

const char* const kDraco = "KHR_draco_mesh_compression";
constexpr std::uint64_t kTriangles = 4;  // glTF's primitive mode

/// One primitive of one mesh, read.
struct Primitive {
    std::size_t mesh = 0, index = 0;
    TriangleMesh geometry;        ///< of triangles only the vertices that they use; no indices for other modes
    std::size_t vertexCount = 0;  ///< of the accessors, which other primitives may share
    bool isTriangles = false;
    bool canCompress = false;  ///< triangles without morph targets, whose vertices must keep their order
    std::optional<std::uint64_t> dracoView;
    std::vector<std::uint32_t> usedVertices;  ///< of triangles: vertex of the accessors for each of the geometry's

    std::string place() const { return fmt::format("mesh {}, primitive {}", mesh, index); }
};

const Json* dracoExtension(const Json& primitive) {
    const auto extensions = primitive.find("extensions");
    if (extensions == primitive.end() || !extensions->is_object()) return nullptr;
    const auto draco = extensions->find(kDraco);
    return draco == extensions->end() ? nullptr : &*draco;
}

bool mustBeFinite(const MeshAttribute& attribute) {
    return attribute.isFloat() &&
           (attribute.semantic == "POSITION" || attribute.semantic == "NORMAL" || attribute.semantic.starts_with("TEXCOORD_"));
}

/// Reads primitives; accessors that several of them share are read once.
class PrimitiveReader {
public:
    explicit PrimitiveReader(const GltfDocument& document) : document_(document) {}

    std::vector<Primitive> readAll() {
        std::vector<Primitive> primitives;
        const Json meshes = document_.json().value("meshes", Json::array());
        for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh) {
            const Json list = meshes[mesh].value("primitives", Json::array());
            for (std::size_t index = 0; index < list.size(); ++index) primitives.push_back(read(list[index], mesh, index));
        }
        return primitives;
    }

private:
    Primitive read(const Json& json, std::size_t mesh, std::size_t index) {
        Primitive primitive;
        primitive.mesh = mesh;
        primitive.index = index;
        const std::string place = primitive.place();
        primitive.isTriangles = document_.number(json, "mode", kTriangles, place) == kTriangles;
        primitive.canCompress = primitive.isTriangles && json.value("targets", Json::array()).empty();
        const Json attributes = json.value("attributes", Json::object());
        if (!attributes.contains("POSITION")) document_.fail(ErrorCode::WrongShape, place, "found no POSITION, expected one");
        if (const Json* draco = dracoExtension(json)) {
            primitive.dracoView = document_.number(*draco, "bufferView", 0, place);
            readDraco(*draco, attributes, primitive);
        } else {
            for (const auto& [semantic, accessor] : attributes.items())
                primitive.geometry.attributes.push_back(shared(attributes, semantic, place));
            if (primitive.isTriangles) readIndices(json, primitive);
        }
        check(attributes, primitive);
        primitive.vertexCount = primitive.geometry.vertexCount();
        // At once: scenes share one set of vertices between dozens of primitives.
        if (primitive.isTriangles) {
            primitive.usedVertices = usedVerticesOf(primitive.geometry);
            primitive.geometry = withoutUnusedVertices(primitive.geometry);
        }
        return primitive;
    }

    static std::vector<std::uint32_t> usedVerticesOf(const TriangleMesh& mesh) {
        std::vector<bool> isUsed(mesh.vertexCount(), false);
        for (const std::uint32_t index : mesh.indices) isUsed[index] = true;
        std::vector<std::uint32_t> used;
        for (std::uint32_t vertex = 0; vertex < isUsed.size(); ++vertex)
            if (isUsed[vertex]) used.push_back(vertex);
        return used;
    }

    MeshAttribute shared(const Json& attributes, const std::string& semantic, const std::string& place) {
        const std::uint64_t accessor = document_.number(attributes, semantic.c_str(), 0, place);
        const auto found = read_.find(accessor);
        if (found == read_.end()) return read_.emplace(accessor, document_.readAccessor(accessor, semantic)).first->second;
        MeshAttribute copy = found->second;
        copy.semantic = semantic;
        return copy;
    }

    void readDraco(const Json& draco, const Json& attributes, Primitive& primitive) const {
        std::vector<DracoAttribute> wanted;
        const Json ids = draco.value("attributes", Json::object());
        for (const auto& [semantic, accessor] : attributes.items()) {
            const MeshAttribute type =
                document_.accessorType(document_.number(attributes, semantic.c_str(), 0, primitive.place()), semantic);
            if (!ids.contains(semantic)) {
                document_.fail(ErrorCode::FormatUnsupported, primitive.place(),
                               fmt::format("found {} outside the Draco stream, expected every attribute in it", semantic));
            }
            const std::uint64_t id = document_.number(ids, semantic.c_str(), 0, primitive.place());
            wanted.push_back({semantic, static_cast<int>(std::min<std::uint64_t>(id, 0x7FFFFFFF)), type.componentType, type.componentCount,
                              type.isNormalized});
        }
        auto decoded = decodeDraco(document_.bufferView(*primitive.dracoView), wanted);
        if (!decoded) {
            document_.fail(ErrorCode::FileUnreadable, fmt::format("{}, bufferView {}", primitive.place(), *primitive.dracoView),
                           fmt::format("found \"{}\", expected a Draco mesh", decoded.error()));
        }
        primitive.geometry = std::move(*decoded);
    }

    void readIndices(const Json& json, Primitive& primitive) const {
        std::vector<std::uint32_t>& indices = primitive.geometry.indices;
        if (!json.contains("indices")) {
            for (std::uint32_t vertex = 0; vertex < primitive.geometry.vertexCount(); ++vertex) indices.push_back(vertex);
            return;
        }
        const MeshAttribute read = document_.readAccessor(document_.number(json, "indices", 0, primitive.place()), "indices");
        const bool isWhole = read.componentType == ComponentType::Uint8 || read.componentType == ComponentType::Uint16 ||
                             read.componentType == ComponentType::Uint32;
        if (!isWhole || read.componentCount != 1)
            document_.fail(ErrorCode::WrongShape, primitive.place(), "found indices of another type, expected unsigned scalars");
        const std::size_t bytes = read.bytesPerVertex();
        for (std::size_t i = 0; i < read.vertexCount(); ++i) {
            std::uint32_t index = 0;  // little-endian, as we are
            std::memcpy(&index, read.values.data() + i * bytes, bytes);
            indices.push_back(index);
        }
    }

    void check(const Json& attributes, const Primitive& primitive) const {
        const TriangleMesh& geometry = primitive.geometry;
        for (const MeshAttribute& attribute : geometry.attributes) {
            const std::string place =
                fmt::format("accessor {} ({} of {})", attributes[attribute.semantic].dump(), attribute.semantic, primitive.place());
            if (attribute.vertexCount() != geometry.vertexCount()) {
                document_.fail(ErrorCode::WrongShape, place,
                               fmt::format("found {} vertices, expected {} as in {}", attribute.vertexCount(), geometry.vertexCount(),
                                           geometry.attributes.front().semantic));
            }
            const int components = attribute.semantic == "POSITION" || attribute.semantic == "NORMAL" ? 3
                                   : attribute.semantic.starts_with("TEXCOORD_")                      ? 2
                                                                                                      : attribute.componentCount;
            if (attribute.componentCount != components) {
                document_.fail(ErrorCode::WrongShape, place,
                               fmt::format("found {} components, expected {}", attribute.componentCount, components));
            }
            if (mustBeFinite(attribute)) checkFinite(attribute, place);
        }
        if (geometry.indices.size() % 3 != 0) {
            document_.fail(ErrorCode::WrongShape, primitive.place(),
                           fmt::format("found {} indices, expected a multiple of 3", geometry.indices.size()));
        }
        for (std::size_t i = 0; i < geometry.indices.size(); ++i) {
            if (geometry.indices[i] < geometry.vertexCount()) continue;
            document_.fail(ErrorCode::WrongShape, fmt::format("{}, index {}", primitive.place(), i),
                           fmt::format("found vertex {}, expected less than {}", geometry.indices[i], geometry.vertexCount()));
        }
    }

    void checkFinite(const MeshAttribute& attribute, const std::string& place) const {
        for (std::size_t vertex = 0; vertex < attribute.vertexCount(); ++vertex) {
            const glm::dvec3 value = attribute.at(vertex);
            if (std::isfinite(value.x) && std::isfinite(value.y) && std::isfinite(value.z)) continue;
            document_.fail(ErrorCode::ValueNotFinite, fmt::format("{}, vertex {}", place, vertex),
                           fmt::format("found ({}, {}, {}), expected finite values", value.x, value.y, value.z));
        }
    }

    const GltfDocument& document_;
    std::map<std::uint64_t, MeshAttribute> read_;
};

/// Bounds of one attribute over every primitive of a mesh: one lattice for all of them, so that shared borders stay shut.
struct Bounds {
    std::array<float, 3> low{std::numeric_limits<float>::max(), std::numeric_limits<float>::max(), std::numeric_limits<float>::max()};
    std::array<float, 3> high{std::numeric_limits<float>::lowest(), std::numeric_limits<float>::lowest(),
                              std::numeric_limits<float>::lowest()};

    void add(const MeshAttribute& attribute) {
        for (std::size_t vertex = 0; vertex < attribute.vertexCount(); ++vertex) {
            const glm::dvec3 value = attribute.at(vertex);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                low[axis] = std::min(low[axis], static_cast<float>(value[static_cast<int>(axis)]));
                high[axis] = std::max(high[axis], static_cast<float>(value[static_cast<int>(axis)]));
            }
        }
    }
    Quantization lattice(int bits, int componentCount) const {
        Quantization result{bits, {low.begin(), low.begin() + componentCount}, 0};
        for (std::size_t axis = 0; axis < static_cast<std::size_t>(componentCount); ++axis)
            result.range = std::max(result.range, high[axis] - low[axis]);
        if (!(result.range > 0)) result.range = 1;  // a single point; Draco wants some extent
        return result;
    }
};

std::optional<Quantization> quantizationOf(const MeshAttribute& attribute, const DracoOptions& options,
                                           const std::map<std::string, Bounds>& bounds) {
    if (!mustBeFinite(attribute)) return std::nullopt;  // integers, colours, weights, tangents: bit for bit
    if (attribute.semantic == "NORMAL") return Quantization{options.normalBits, {}, 1};
    const int bits = attribute.semantic == "POSITION"     ? options.positionBits
                     : attribute.semantic == "TEXCOORD_1" ? options.lightMapUvBits
                                                          : options.uvBits;
    return bounds.at(attribute.semantic).lattice(bits, attribute.componentCount);
}

/// The scene on its way to a GLB: JSON whose buffer views are being replaced, and the bytes of the new ones.
class GlbBuilder {
public:
    GlbBuilder(const GltfDocument& document, const std::vector<Primitive>& primitives, const ClusterMap* clusters)
        : document_(document), primitives_(primitives), clusters_(clusters), json_(document.json()) {}

    /// options  none: only primitives that are Draco streams already, and gain an attribute, are coded anew, bit for bit
    MeshSize build(const DracoOptions* options, std::vector<std::byte>& glb) {
        const std::vector<std::optional<DracoMesh>> coded = encodeAll(options);
        findFreeAccessors(coded);
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            if (coded[i]) {
                replace(primitives_[i], *coded[i]);
            } else if (clusters_ != nullptr && primitives_[i].isTriangles) {
                addClusters(primitives_[i]);
            }
        }
        if (std::any_of(coded.begin(), coded.end(), [](const auto& mesh) { return mesh.has_value(); })) declareDraco();
        embedImages();
        const std::vector<std::byte> buffer = packBuffer();
        if (buffer.empty()) {
            json_.erase("buffers");
        } else {
            json_["buffers"] = Json::array({Json{{"byteLength", buffer.size()}}});
        }
        glb = assembleGlb(json_, buffer);
        MeshSize size;
        size.fileBytesIn = document_.fileBytes();
        size.fileBytesOut = glb.size();
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            const TriangleMesh& written = coded[i] ? coded[i]->decoded : primitives_[i].geometry;
            size.vertexCount += static_cast<std::int64_t>(written.vertexCount());
            size.triangleCount += static_cast<std::int64_t>(written.triangleCount());
        }
        return size;
    }

private:
    std::vector<std::optional<DracoMesh>> encodeAll(const DracoOptions* options) const {
        std::map<std::size_t, std::map<std::string, Bounds>> boundsOfMesh;
        for (const Primitive& primitive : primitives_) {
            for (const MeshAttribute& attribute : primitive.geometry.attributes) {
                if (primitive.canCompress && mustBeFinite(attribute)) boundsOfMesh[primitive.mesh][attribute.semantic].add(attribute);
            }
        }
        std::vector<std::optional<DracoMesh>> coded(primitives_.size());
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            if (!primitives_[i].canCompress || primitives_[i].geometry.indices.empty()) continue;
            if (options == nullptr && !(clusters_ != nullptr && primitives_[i].dracoView)) continue;
            const TriangleMesh mesh = clusters_ != nullptr ? withClusters(primitives_[i]) : primitives_[i].geometry;
            std::vector<std::optional<Quantization>> quantization;
            for (const MeshAttribute& attribute : mesh.attributes) {
                quantization.emplace_back();
                if (options != nullptr) quantization.back() = quantizationOf(attribute, *options, boundsOfMesh[primitives_[i].mesh]);
            }
            auto encoded = encodeDraco(mesh, quantization, (options != nullptr ? *options : DracoOptions{}).speed);
            if (encoded)
                coded[i] = std::move(*encoded);  // what Draco cannot code, such as nothing but degenerate triangles, stays as it is
        }
        return coded;
    }

    std::vector<std::uint8_t> clustersOf(const Primitive& primitive) const {
        auto found = clustersOfVertices(primitive.geometry, *clusters_);
        if (!found) document_.fail(ErrorCode::WrongShape, primitive.place(), found.error());
        return std::move(*found);
    }

    /// An attribute of that name which the scene brings along is of another cook.
    TriangleMesh withClusters(const Primitive& primitive) const {
        TriangleMesh mesh = primitive.geometry;
        std::erase_if(mesh.attributes, [](const MeshAttribute& attribute) { return attribute.semantic == kBasisAttribute; });
        MeshAttribute& added = mesh.attributes.emplace_back();
        added.semantic = kBasisAttribute;
        added.componentType = ComponentType::Uint8;
        added.componentCount = 1;
        for (const std::uint8_t cluster : clustersOf(primitive)) added.values.push_back(static_cast<std::byte>(cluster));
        return mesh;
    }

    /// Beside vertices that stay where they are: one byte of four, as glTF wants vertices to lie.
    void addClusters(const Primitive& primitive) {
        if (primitive.dracoView)
            document_.fail(
                ErrorCode::FormatUnsupported, primitive.place(),
                "found a Draco stream that cannot be coded anew, expected one without morph targets that can take a vertex attribute");
        constexpr std::size_t kStride = 4;
        const std::vector<std::uint8_t> clusters = clustersOf(primitive);
        std::vector<std::byte> bytes(kStride * primitive.vertexCount);
        for (std::size_t i = 0; i < clusters.size(); ++i) bytes[kStride * primitive.usedVertices[i]] = static_cast<std::byte>(clusters[i]);
        constexpr int kArrayBuffer = 34962;
        Json accessor = clusterAccessor(primitive.vertexCount);
        accessor["bufferView"] = addView(std::move(bytes), {{"byteStride", kStride}, {"target", kArrayBuffer}});
        jsonOf(primitive)["attributes"][kBasisAttribute] = addAccessor(std::move(accessor));
    }

    static Json clusterAccessor(std::size_t vertexCount) {
        return {{"componentType", static_cast<int>(ComponentType::Uint8)}, {"count", vertexCount}, {"type", "SCALAR"}};
    }

    Json& jsonOf(const Primitive& primitive) { return json_["meshes"][primitive.mesh]["primitives"][primitive.index]; }

    /// Accessors that only coded primitives used. They are replaced in place and never removed, so that no reference to an accessor moves,
    /// in extensions that we do not know either.
    void findFreeAccessors(const std::vector<std::optional<DracoMesh>>& coded) {
        std::set<std::uint64_t> used, kept;
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            const Json& primitive = jsonOf(primitives_[i]);
            std::set<std::uint64_t>& users = coded[i] ? used : kept;
            for (const Json& accessor : primitive["attributes"]) users.insert(accessor.get<std::uint64_t>());
            if (primitive.contains("indices")) users.insert(primitive["indices"].get<std::uint64_t>());
            for (const Json& target : primitive.value("targets", Json::array())) {
                for (const Json& accessor : target) kept.insert(accessor.get<std::uint64_t>());
            }
        }
        const auto keep = [&kept](const Json& user, const char* key) {
            if (user.contains(key)) kept.insert(user[key].get<std::uint64_t>());
        };
        for (const Json& skin : json_.value("skins", Json::array())) keep(skin, "inverseBindMatrices");
        for (const Json& animation : json_.value("animations", Json::array())) {
            for (const Json& sampler : animation.value("samplers", Json::array())) {
                keep(sampler, "input");
                keep(sampler, "output");
            }
        }
        std::set_difference(used.begin(), used.end(), kept.begin(), kept.end(), std::back_inserter(freeAccessors_));
        std::reverse(freeAccessors_.begin(), freeAccessors_.end());  // lowest at the back, to be taken first
    }

    std::size_t addAccessor(Json accessor) {
        if (freeAccessors_.empty()) {
            json_["accessors"].push_back(std::move(accessor));
            return json_["accessors"].size() - 1;
        }
        const std::uint64_t slot = freeAccessors_.back();
        freeAccessors_.pop_back();
        json_["accessors"][slot] = std::move(accessor);
        return slot;
    }

    struct NewView {
        std::vector<std::byte> bytes;
        Json json;
    };
    std::size_t addView(std::vector<std::byte> bytes, Json json = Json::object()) {
        newViews_.push_back({std::move(bytes), std::move(json)});
        return viewCount() + newViews_.size() - 1;
    }
    std::size_t viewCount() const { return document_.json().value("bufferViews", Json::array()).size(); }

    void replace(const Primitive& primitive, const DracoMesh& coded) {
        Json attributes = Json::object(), ids = Json::object();
        for (std::size_t i = 0; i < coded.decoded.attributes.size(); ++i) {
            const MeshAttribute& attribute = coded.decoded.attributes[i];
            const bool isOurs = clusters_ != nullptr && attribute.semantic == kBasisAttribute;
            Json accessor = isOurs ? clusterAccessor(0)
                                   : document_.entry("accessors", jsonOf(primitive)["attributes"][attribute.semantic].get<std::uint64_t>());
            for (const char* gone : {"bufferView", "byteOffset", "sparse", "min", "max"}) accessor.erase(gone);
            accessor["count"] = attribute.vertexCount();
            if (attribute.semantic == "POSITION") addBounds(attribute, accessor);
            attributes[attribute.semantic] = addAccessor(std::move(accessor));
            ids[attribute.semantic] = coded.uniqueIds[i];
        }
        const bool isShort = coded.decoded.vertexCount() < 0xFFFF;  // the last value of each width restarts primitives
        Json indices = {{"componentType", static_cast<int>(isShort ? ComponentType::Uint16 : ComponentType::Uint32)},
                        {"count", coded.decoded.indices.size()},
                        {"type", "SCALAR"}};
        const std::size_t indexAccessor = addAccessor(std::move(indices));
        Json& json = jsonOf(primitive);
        json["attributes"] = std::move(attributes);
        json["indices"] = indexAccessor;
        json["extensions"][kDraco] = {{"bufferView", addView(coded.bytes)}, {"attributes", std::move(ids)}};
    }

    static void addBounds(const MeshAttribute& position, Json& accessor) {
        Bounds bounds;
        bounds.add(position);
        accessor["min"] = bounds.low;
        accessor["max"] = bounds.high;
    }

    void declareDraco() {
        for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
            Json names = json_.value(list, Json::array());
            if (std::find(names.begin(), names.end(), kDraco) == names.end()) names.push_back(kDraco);
            json_[list] = std::move(names);
        }
    }

    /// Image files beside the scene move into the GLB, which may lie elsewhere; what cannot be read stays a uri.
    void embedImages() {
        if (!json_.contains("images")) return;
        for (Json& image : json_["images"]) {
            const std::string uri = image.value("uri", "");
            if (uri.empty() || uri.starts_with("data:")) continue;
            auto bytes = document_.readBeside(uri);
            const std::string mimeType = bytes ? imageType(*bytes) : "";
            if (mimeType.empty()) continue;
            image.erase("uri");
            image["mimeType"] = mimeType;
            image["bufferView"] = addView(std::move(*bytes));
        }
    }

    static std::string imageType(std::span<const std::byte> bytes) {
        const std::string_view head(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 16));
        if (head.starts_with("\x89PNG")) return "image/png";
        if (head.starts_with("\xFF\xD8\xFF")) return "image/jpeg";
        if (head.starts_with("RIFF") && head.substr(8).starts_with("WEBP")) return "image/webp";
        if (head.starts_with("\xABKTX 20\xBB")) return "image/ktx2";
        return {};
    }

    /// One buffer with the views that are still referred to, in their old order, then the new ones; references are renumbered.
    std::vector<std::byte> packBuffer() {
        std::set<std::uint64_t> used;
        visitBufferViews(std::as_const(json_), [&used](const Json& reference) { used.insert(reference.get<std::uint64_t>()); });
        std::map<std::uint64_t, std::size_t> newIndexOf;
        Json views = Json::array();
        std::vector<std::byte> buffer;
        for (const std::uint64_t old : used) {
            if (old >= viewCount() + newViews_.size()) {
                document_.fail(ErrorCode::WrongShape, "bufferViews",
                               fmt::format("found a reference to entry {}, expected less than {}", old, viewCount()));
            }
            const bool isNew = old >= viewCount();
            Json view = isNew ? newViews_[old - viewCount()].json : document_.entry("bufferViews", old);
            const std::span<const std::byte> bytes =
                isNew ? std::span<const std::byte>(newViews_[old - viewCount()].bytes) : document_.bufferView(old);
            buffer.resize((buffer.size() + 3) / 4 * 4);
            view["buffer"] = 0;
            view["byteOffset"] = buffer.size();
            view["byteLength"] = bytes.size();
            buffer.insert(buffer.end(), bytes.begin(), bytes.end());
            newIndexOf[old] = views.size();
            views.push_back(std::move(view));
        }
        visitBufferViews(json_, [&newIndexOf](Json& reference) { reference = newIndexOf.at(reference.get<std::uint64_t>()); });
        if (views.empty()) {
            json_.erase("bufferViews");
        } else {
            json_["bufferViews"] = std::move(views);
        }
        return buffer;
    }

    const GltfDocument& document_;
    const std::vector<Primitive>& primitives_;
    const ClusterMap* clusters_;  ///< none: vertices get no cluster
    Json json_;
    std::vector<std::uint64_t> freeAccessors_;
    std::vector<NewView> newViews_;
};

/// Which part of a scene beside its geometry a copy changed, if any. Buffer views are renumbered by writing.
std::string otherThanGeometry(const Json& original, const Json& copy) {
    for (const char* part : {"scene", "scenes", "nodes", "skins", "animations", "cameras", "materials", "textures", "samplers"}) {
        Json ours = original.value(part, Json()), theirs = copy.value(part, Json());
        for (Json* each : {&ours, &theirs}) visitBufferViews(*each, [](Json& reference) { reference = 0; });
        if (ours != theirs) return part;
    }
    const Json ours = original.value("meshes", Json::array()), theirs = copy.value("meshes", Json::array());
    for (std::size_t mesh = 0; mesh < ours.size(); ++mesh)
        for (std::size_t i = 0; i < ours[mesh]["primitives"].size(); ++i)
            if (mesh >= theirs.size() || i >= theirs[mesh]["primitives"].size() ||
                ours[mesh]["primitives"][i].value("material", Json()) != theirs[mesh]["primitives"][i].value("material", Json()))
                return "materials of a primitive";
    return {};
}

Result<void> checkOptions(const DracoOptions& options) {
    const auto outside = [](int value, int low, int high) { return value < low || value > high; };
    for (const auto& [name, bits] : {std::pair{"position", options.positionBits},
                                     {"normal", options.normalBits},
                                     {"uv", options.uvBits},
                                     {"light-map uv", options.lightMapUvBits}}) {
        if (outside(bits, 2, 30))
            return failure(ErrorCode::InvalidRequest, fmt::format("Draco {} bits", name), fmt::format("found {}, expected 2 to 30", bits));
    }
    if (outside(options.speed, 0, 10))
        return failure(ErrorCode::InvalidRequest, "Draco speed", fmt::format("found {}, expected 0 to 10", options.speed));
    return {};
}

}  // namespace

struct GltfScene::State {
    GltfDocument document;
    std::vector<Primitive> primitives;
    std::vector<MaterialNeeds> materials;
    std::int64_t vertexCount = 0, triangleCount = 0;
    bool hasLightMapUvs = false;

    explicit State(const std::filesystem::path& file) : document(file), primitives(PrimitiveReader(document).readAll()) {
        readMaterials();
        hasLightMapUvs = !primitives.empty();
        std::set<std::uint64_t> counted;
        for (const Primitive& primitive : primitives) {
            const Json& json = document.json()["meshes"][primitive.mesh]["primitives"][primitive.index];
            if (counted.insert(json["attributes"]["POSITION"].get<std::uint64_t>()).second)
                vertexCount += static_cast<std::int64_t>(primitive.vertexCount);
            triangleCount += static_cast<std::int64_t>(primitive.geometry.triangleCount());
            hasLightMapUvs &= primitive.geometry.find("TEXCOORD_1") != nullptr;
        }
    }

    /// Every material of the file, then glTF's default one if a primitive has none.
    void readMaterials() {
        for (const Json& material : document.json().value("materials", Json::array())) materials.push_back(materialNeeds(material));
        const bool needsDefault = std::any_of(primitives.begin(), primitives.end(), [this](const Primitive& primitive) {
            return !document.json()["meshes"][primitive.mesh]["primitives"][primitive.index].contains("material");
        });
        if (!needsDefault) return;
        materials.push_back(materialNeeds(Json::object()));
        materials.back().name = "default";
    }
};

GltfScene::GltfScene(std::unique_ptr<State> state) : state_(std::move(state)) {}
GltfScene::GltfScene(GltfScene&&) noexcept = default;
GltfScene& GltfScene::operator=(GltfScene&&) noexcept = default;
GltfScene::~GltfScene() = default;

const std::vector<MaterialNeeds>& GltfScene::materials() const {
    return state_->materials;
}
bool GltfScene::hasLightMapUvs() const {
    return state_->hasLightMapUvs;
}
std::int64_t GltfScene::vertexCount() const {
    return state_->vertexCount;
}
std::int64_t GltfScene::triangleCount() const {
    return state_->triangleCount;
}

std::vector<std::filesystem::path> gltfFilesBeside(const std::filesystem::path& file, GltfFiles which) {
    constexpr std::array<const char*, 2> kArrays = {"buffers", "images"};
    try {
        return GltfDocument::filesBeside(file, std::span(kArrays).first(which == GltfFiles::All ? 2 : 1));
    } catch (const GltfFault&) {
        return {};
    } catch (const nlohmann::json::exception&) {
        return {};
    }
}

Result<GltfScene> GltfScene::load(const std::filesystem::path& file) {
    try {
        return GltfScene(std::make_unique<State>(file));
    } catch (const GltfFault& fault) {
        return tl::make_unexpected(fault.error);
    } catch (const nlohmann::json::exception& exception) {
        return failure(ErrorCode::WrongShape, file.string(),
                       fmt::format("found JSON of another shape (\"{}\"), expected glTF 2.0", oneLine(exception.what())));
    }
}

std::vector<const TriangleMesh*> GltfScene::triangleMeshes() const {
    std::vector<const TriangleMesh*> meshes;
    for (const Primitive& primitive : state_->primitives)
        if (primitive.isTriangles) meshes.push_back(&primitive.geometry);
    return meshes;
}

Result<MeshSize> GltfScene::writeDraco(const std::filesystem::path& file, const DracoOptions& options, const ClusterMap* clusters) const {
    if (const auto good = checkOptions(options); !good) return tl::make_unexpected(good.error());
    return write(file, &options, clusters);
}

Result<MeshSize> GltfScene::writePlain(const std::filesystem::path& file, const ClusterMap* clusters) const {
    return write(file, nullptr, clusters);
}

Result<MeshSize> GltfScene::write(const std::filesystem::path& file, const DracoOptions* options, const ClusterMap* clusters) const {
    try {
        std::vector<std::byte> glb;
        const MeshSize size = GlbBuilder(state_->document, state_->primitives, clusters).build(options, glb);
        if (glb.size() > std::numeric_limits<std::uint32_t>::max()) {
            return failure(ErrorCode::WrongShape, file.string(),
                           fmt::format("found {} bytes, expected less than 4 GiB in a GLB", glb.size()));
        }
        if (const auto written = writeWholeFile(file, glb); !written) return tl::make_unexpected(written.error());
        return size;
    } catch (const GltfFault& fault) {
        return tl::make_unexpected(fault.error);
    } catch (const nlohmann::json::exception& exception) {
        return failure(ErrorCode::WrongShape, state_->document.file().string(),
                       fmt::format("found JSON of another shape (\"{}\"), expected glTF 2.0", oneLine(exception.what())));
    }
}

Result<MeshError> GltfScene::errorOf(const GltfScene& cooked) const {
    const std::vector<Primitive>& ours = state_->primitives;
    const std::vector<Primitive>& theirs = cooked.state_->primitives;
    const std::string subject = cooked.state_->document.file().string();
    if (ours.size() != theirs.size()) {
        return failure(ErrorCode::Verification, subject, fmt::format("found {} primitives, expected {}", theirs.size(), ours.size()));
    }
    if (const std::string what = otherThanGeometry(state_->document.json(), cooked.state_->document.json()); !what.empty())
        return failure(ErrorCode::Verification, subject, fmt::format("found other {}, expected those of the source", what));
    MeshError worst;
    std::map<std::size_t, std::map<std::string, Bounds>> boundsOfMesh;
    for (const Primitive& primitive : ours)
        for (const MeshAttribute& attribute : primitive.geometry.attributes)
            if (primitive.isTriangles && mustBeFinite(attribute)) boundsOfMesh[primitive.mesh][attribute.semantic].add(attribute);
    for (const auto& [mesh, bounds] : boundsOfMesh)
        for (const auto& [semantic, each] : bounds) {
            if (semantic == "POSITION")
                worst.positionExtent = std::max(worst.positionExtent, static_cast<double>(each.lattice(1, 3).range));
            if (semantic == "TEXCOORD_1")
                worst.lightMapUvExtent = std::max(worst.lightMapUvExtent, static_cast<double>(each.lattice(1, 2).range));
        }
    for (std::size_t i = 0; i < ours.size(); ++i) {
        if (!ours[i].isTriangles) continue;
        double step = 0;
        if (theirs[i].dracoView) {
            const auto found = dracoPositionStep(cooked.state_->document.bufferView(*theirs[i].dracoView));
            if (!found) return failure(ErrorCode::Verification, subject, fmt::format("found \"{}\", expected a Draco mesh", found.error()));
            step = *found;
        }
        const auto match = matchTriangles(ours[i].geometry, theirs[i].geometry, step);
        if (!match) return failure(ErrorCode::Verification, fmt::format("{}, {}", subject, theirs[i].place()), match.error());
        worst.position = std::max(worst.position, match->position);
        worst.normalRadians = std::max(worst.normalRadians, match->normalRadians);
        worst.lightMapUv = std::max(worst.lightMapUv, match->lightMapUv);
    }
    return worst;
}

}  // namespace lightcook::formats
