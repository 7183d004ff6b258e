#include "formats/gltf/glb_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "formats/chart_clusters.h"
#include "formats/gltf/attribute_bounds.h"
#include "formats/gltf/draco_mesh.h"
#include "formats/gltf/foreign_extensions.h"
#include "formats/read_file.h"

namespace lightcook::formats {
namespace {

/// Quantization of TEXCOORD_2 and up [bits]: sets that an engine reads next to never, such as the UVs from before a light map was repacked.
constexpr int kFurtherUvBits = 16;

bool isFurtherUv(const std::string& semantic) {
    return semantic.starts_with("TEXCOORD_") && semantic != "TEXCOORD_0" && semantic != "TEXCOORD_1";
}

std::optional<Quantization> quantizationOf(const MeshAttribute& attribute, const DracoOptions& options,
                                           const std::map<std::string, AttributeBounds>& bounds) {
    if (!mustBeFinite(attribute)) return std::nullopt;  // integers, colours, weights and tangents are kept bit for bit
    if (attribute.semantic == "NORMAL") return Quantization{options.normalBits, {}, 1};
    const int bits = attribute.semantic == "POSITION"     ? options.positionBits
                     : attribute.semantic == "TEXCOORD_1" ? options.lightMapUvBits
                     : isFurtherUv(attribute.semantic)    ? kFurtherUvBits
                                                          : options.uvBits;
    return bounds.at(attribute.semantic).lattice(bits, attribute.componentCount);
}

/// The buffer views of the new GLB: those of the document that are still referred to, and new ones.
class BufferViews {
public:
    explicit BufferViews(const GltfDocument& document) : document_(document) {}

    /// Adds a view and returns its index.
    std::size_t add(std::vector<std::byte> bytes, Json json = Json::object()) {
        newViews_.push_back({std::move(bytes), std::move(json)});
        return viewCount() + newViews_.size() - 1;
    }

    /// Moves image files into the GLB, which may lie elsewhere. Those that cannot be read, or are no pictures, stay uris.
    void embedImages(Json& json) {
        if (!json.contains("images")) return;
        for (Json& image : json["images"]) {
            const std::string uri = image.value("uri", "");
            if (uri.empty() || uri.starts_with("data:")) continue;
            auto bytes = readWholeFile(document_.pathOf(uri));
            const std::string mimeType = bytes ? imageType(*bytes) : "";
            if (mimeType.empty()) continue;
            image.erase("uri");
            image["mimeType"] = mimeType;
            image["bufferView"] = add(std::move(*bytes));
        }
    }

    /// Returns the one buffer of the GLB: the views that `json` still refers to in their old order, then the new ones. Renumbers the
    /// references.
    /// pinned  indices that extensions may refer to (foreign_extensions.h): these views stay, with their indices
    std::vector<std::byte> pack(Json& json, const std::set<std::uint64_t>& pinned) {
        std::set<std::uint64_t> used;
        visitBufferViews(std::as_const(json), [&used](const Json& reference) { used.insert(reference.get<std::uint64_t>()); });
        for (const std::uint64_t index : pinned)
            if (index < viewCount()) used.insert(index);
        std::map<std::uint64_t, std::size_t> newIndexOf;
        Json views = Json::array();
        std::vector<std::byte> buffer;
        for (const std::optional<std::uint64_t>& slot : slotsOf(used, pinned)) {
            if (!slot) {
                // A view in front of one that keeps its index.
                constexpr std::size_t kLeastBytes = 4;
                buffer.resize((buffer.size() + 3) / 4 * 4);
                views.push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", kLeastBytes}});
                buffer.resize(buffer.size() + kLeastBytes);
                continue;
            }
            const std::uint64_t old = *slot;
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
        visitBufferViews(json, [&newIndexOf](Json& reference) { reference = newIndexOf.at(reference.get<std::uint64_t>()); });
        if (views.empty()) {
            json.erase("bufferViews");
        } else {
            json["bufferViews"] = std::move(views);
        }
        return buffer;
    }

private:
    struct NewView {
        std::vector<std::byte> bytes;
        Json json;
    };
    std::size_t viewCount() const { return document_.json().value("bufferViews", Json::array()).size(); }

    /// Returns the views to write, in order: pinned ones at their old indices, the others in ascending order in the places between and
    /// behind. Nothing: no view is left for a place.
    std::vector<std::optional<std::uint64_t>> slotsOf(const std::set<std::uint64_t>& used, const std::set<std::uint64_t>& pinned) const {
        const auto isPinned = [&](std::uint64_t index) { return index < viewCount() && pinned.contains(index); };
        std::vector<std::uint64_t> movable;
        std::size_t left = 0;  // pinned views that have no place yet
        for (const std::uint64_t index : used) {
            left += isPinned(index) ? 1 : 0;
            if (!isPinned(index)) movable.push_back(index);
        }
        std::vector<std::optional<std::uint64_t>> slots;
        for (std::size_t next = 0; left > 0 || next < movable.size();) {
            std::optional<std::uint64_t>& slot = slots.emplace_back();
            if (isPinned(slots.size() - 1)) {
                slot = slots.size() - 1;
                --left;
            } else if (next < movable.size()) {
                slot = movable[next++];
            }
        }
        return slots;
    }

    static std::string imageType(std::span<const std::byte> bytes) {
        const std::string_view head(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 16));
        if (head.starts_with("\x89PNG")) return "image/png";
        if (head.starts_with("\xFF\xD8\xFF")) return "image/jpeg";
        if (head.starts_with("RIFF") && head.substr(8).starts_with("WEBP")) return "image/webp";
        if (head.starts_with("\xABKTX 20\xBB")) return "image/ktx2";
        return {};
    }

    const GltfDocument& document_;
    std::vector<NewView> newViews_;
};

/// Replaces the geometry of the JSON, primitive by primitive, and collects the new buffer views.
class GlbBuilder {
public:
    GlbBuilder(const GltfDocument& document, const std::vector<Primitive>& primitives, const GlbChanges& changes)
        : document_(document),
          primitives_(primitives),
          clusters_(changes.clusters),
          isWithoutDraco_(changes.isWithoutDraco),
          oldUvs_(freeUv(primitives)),
          foreign_(foreignIntegers(document.json())),
          json_(document.json()),
          views_(document) {
        if (changes.lightMapUvs != nullptr) nameUvs(*changes.lightMapUvs);
    }

    BuiltGlb build(const DracoOptions* options) {
        const std::vector<std::optional<DracoMesh>> coded = encodeAll(options);
        findFreeAccessors(coded);
        const std::vector<TriangleMesh> plain = writePlain();
        if (!uvs_.empty()) replaceUvs(coded);
        if (!uvs_.empty()) removeUvsOfLines();
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            if (coded[i]) {
                replace(primitives_[i], *coded[i]);
            } else if (clusters_ != nullptr && primitives_[i].isTriangles) {
                addClusters(primitives_[i]);
            }
        }
        if (std::any_of(coded.begin(), coded.end(), [](const auto& mesh) { return mesh.has_value(); })) declareDraco();
        if (isWithoutDraco_ || !uvs_.empty()) forgetDraco();
        emptyFreeAccessors();
        if (!isWithoutDraco_) views_.embedImages(json_);
        checkNoForeignBuffers(document_, json_);
        const std::vector<std::byte> buffer = views_.pack(json_, foreign_);
        if (buffer.empty()) {
            json_.erase("buffers");
        } else {
            json_["buffers"] = Json::array({Json{{"byteLength", buffer.size()}}});
        }
        BuiltGlb glb;
        glb.bytes = assembleGlb(json_, buffer);
        MeshSize& size = glb.size;
        size.fileBytesIn = document_.fileBytes();
        size.fileBytesOut = glb.bytes.size();
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            const TriangleMesh& written = coded[i] ? coded[i]->decoded : plain[i];
            const auto vertexCount = static_cast<std::int64_t>(written.vertexCount());
            size.vertexCount += vertexCount;
            if (primitives_[i].isTriangles) size.triangleVertexCount += vertexCount;
            size.triangleCount += static_cast<std::int64_t>(written.triangleCount());
        }
        return glb;
    }

private:
    std::vector<std::optional<DracoMesh>> encodeAll(const DracoOptions* options) const {
        BoundsOfMeshes boundsOfMesh = boundsOfMeshes(primitives_, [](const Primitive& primitive) { return primitive.canCompress; });
        std::vector<std::optional<DracoMesh>> coded(primitives_.size());
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            if (!primitives_[i].canCompress || primitives_[i].geometry.indices.empty()) continue;
            if (isPlain(primitives_[i]) || (options == nullptr && !(clusters_ != nullptr && primitives_[i].dracoView))) continue;
            const TriangleMesh mesh = changed(primitives_[i]);
            std::vector<std::optional<Quantization>> quantization;
            for (const MeshAttribute& attribute : mesh.attributes) {
                quantization.emplace_back();
                if (options != nullptr) quantization.back() = quantizationOf(attribute, *options, boundsOfMesh[primitives_[i].mesh]);
            }
            auto encoded = encodeDraco(mesh, quantization, (options != nullptr ? *options : DracoOptions{}).speed);
            if (encoded) coded[i] = std::move(*encoded);  // Draco refuses, say, meshes of degenerate triangles only: they stay as they are
        }
        return coded;
    }

    std::vector<std::uint8_t> clustersOf(const Primitive& primitive) const {
        auto found = clustersOfVertices(primitive.geometry, *clusters_);
        if (!found) document_.fail(ErrorCode::WrongShape, primitive.place(), found.error());
        return std::move(*found);
    }

    /// Returns the geometry with the attributes that change. Replaces kBasisAttribute if the scene has one already: it comes from an
    /// earlier cook.
    TriangleMesh changed(const Primitive& primitive) const {
        TriangleMesh mesh = primitive.geometry;
        if (const auto uvs = uvs_.find(&primitive); uvs != uvs_.end()) {
            const auto uv = std::ranges::find(mesh.attributes, "TEXCOORD_1", &MeshAttribute::semantic);
            MeshAttribute old = std::exchange(*uv, uvAttribute(*uvs->second));
            old.semantic = oldUvs_;
            mesh.attributes.push_back(std::move(old));
        }
        if (clusters_ == nullptr) return mesh;
        std::erase_if(mesh.attributes, [](const MeshAttribute& attribute) { return attribute.semantic == kBasisAttribute; });
        MeshAttribute& added = mesh.attributes.emplace_back();
        added.semantic = kBasisAttribute;
        added.componentType = ComponentType::Uint8;
        added.componentCount = 1;
        for (const std::uint8_t cluster : clustersOf(primitive)) added.values.push_back(static_cast<std::byte>(cluster));
        return mesh;
    }

    [[noreturn]] void failToCode(const Primitive& primitive) const {
        document_.fail(
            ErrorCode::FormatUnsupported, primitive.place(),
            "found a Draco stream that cannot be coded anew, expected one without morph targets that can take a vertex attribute");
    }

    void nameUvs(const std::vector<std::vector<glm::vec2>>& uvs) {
        std::size_t next = 0;
        for (const Primitive& primitive : primitives_)
            if (primitive.isTriangles) uvs_[&primitive] = &uvs[next++];
    }

    static MeshAttribute uvAttribute(const std::vector<glm::vec2>& uvs) {
        MeshAttribute attribute;
        attribute.semantic = "TEXCOORD_1";
        attribute.componentCount = 2;
        const std::span<const std::byte> bytes = std::as_bytes(std::span(uvs));
        attribute.values.assign(bytes.begin(), bytes.end());
        return attribute;
    }

    /// Writes the new UVs of primitives that are not written anew as a whole. Primitives that share an accessor share the new one, whose
    /// vertices that no triangle uses are 0.
    void replaceUvs(const std::vector<std::optional<DracoMesh>>& coded) {
        const auto isDone = [&](const Primitive& primitive) {
            return isPlain(primitive) || coded[static_cast<std::size_t>(&primitive - primitives_.data())].has_value();
        };
        std::map<std::uint64_t, std::vector<glm::vec2>> values;
        for (const auto& [primitive, uvs] : uvs_) {
            if (isDone(*primitive)) continue;
            if (primitive->dracoView) failToCode(*primitive);
            Json& attributes = jsonOf(*primitive)["attributes"];
            const auto accessor = attributes["TEXCOORD_1"].get<std::uint64_t>();
            attributes[oldUvs_] = accessor;
            std::vector<glm::vec2>& all = values[accessor];
            all.resize(primitive->vertexCount);
            for (std::size_t i = 0; i < uvs->size(); ++i) all[primitive->usedVertices[i]] = (*uvs)[i];
        }
        constexpr int kArrayBuffer = 34962;
        for (const auto& [accessor, uvs] : values) {
            const std::span<const std::byte> bytes = std::as_bytes(std::span(uvs));
            const std::size_t view = views_.add({bytes.begin(), bytes.end()}, {{"target", kArrayBuffer}});
            Json made = uvAccessor(uvs.size());
            made["bufferView"] = view;
            const std::size_t added = addAccessor(std::move(made));
            for (const auto& [primitive, ignored] : uvs_) {
                Json& uv = jsonOf(*primitive)["attributes"]["TEXCOORD_1"];
                if (!isDone(*primitive) && uv == accessor) uv = added;
            }
        }
    }
    /// Removes the light-map UVs of lines and points: they have no charts, so nothing says where their places of the old map went.
    void removeUvsOfLines() {
        for (const Primitive& primitive : primitives_) {
            Json& attributes = jsonOf(primitive)["attributes"];
            if (primitive.isTriangles || !attributes.contains("TEXCOORD_1")) continue;
            // The sets of a primitive are numbered without a gap.
            if (attributes.contains("TEXCOORD_2"))
                document_.fail(
                    ErrorCode::WrongShape, primitive.place(),
                    "found TEXCOORD_1 and TEXCOORD_2 on lines or points, expected no light-map UVs on them: they cannot be moved");
            attributes.erase("TEXCOORD_1");
        }
    }
    static Json uvAccessor(std::size_t vertexCount) {
        return {{"componentType", static_cast<int>(ComponentType::Float32)}, {"count", vertexCount}, {"type", "VEC2"}};
    }

    /// Adds the clusters of a primitive that is not encoded, one byte in four: glTF aligns vertex attributes to four bytes.
    void addClusters(const Primitive& primitive) {
        if (primitive.dracoView) failToCode(primitive);
        constexpr std::size_t kStride = 4;
        const std::vector<std::uint8_t> clusters = clustersOf(primitive);
        std::vector<std::byte> bytes(kStride * primitive.vertexCount);
        for (std::size_t i = 0; i < clusters.size(); ++i) bytes[kStride * primitive.usedVertices[i]] = static_cast<std::byte>(clusters[i]);
        constexpr int kArrayBuffer = 34962;
        Json accessor = clusterAccessor(primitive.vertexCount);
        accessor["bufferView"] = views_.add(std::move(bytes), {{"byteStride", kStride}, {"target", kArrayBuffer}});
        jsonOf(primitive)["attributes"][kBasisAttribute] = addAccessor(std::move(accessor));
    }

    static Json clusterAccessor(std::size_t vertexCount) {
        return {{"componentType", static_cast<int>(ComponentType::Uint8)}, {"count", vertexCount}, {"type", "SCALAR"}};
    }

    Json& jsonOf(const Primitive& primitive) { return json_["meshes"][primitive.mesh]["primitives"][primitive.index]; }

    /// Finds the accessors that only primitives used which are written anew. New accessors take their places, and none is
    /// removed: extensions that we do not know may refer to accessors by index.
    void findFreeAccessors(const std::vector<std::optional<DracoMesh>>& coded) {
        std::set<std::uint64_t> used, kept = foreignAccessors(document_.json());
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            const Json& primitive = jsonOf(primitives_[i]);
            std::set<std::uint64_t>& users = coded[i] || isPlain(primitives_[i]) ? used : kept;
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

    /// Removes the values of the free accessors whose places no new accessor took.
    void emptyFreeAccessors() {
        for (const std::uint64_t slot : freeAccessors_)
            for (const char* key : {"bufferView", "byteOffset", "sparse", "min", "max"}) json_["accessors"][slot].erase(key);
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

    /// Returns the accessor of an attribute that is written anew, without a buffer view.
    Json declaredAccessor(const Primitive& primitive, const MeshAttribute& attribute) {
        const bool isOurs = clusters_ != nullptr && attribute.semantic == kBasisAttribute;
        const bool isNewUv = uvs_.contains(&primitive) && attribute.semantic == "TEXCOORD_1";
        const bool isOldUv = uvs_.contains(&primitive) && attribute.semantic == oldUvs_;
        const std::string source = isOldUv ? "TEXCOORD_1" : attribute.semantic;
        Json accessor = isOurs    ? clusterAccessor(0)
                        : isNewUv ? uvAccessor(0)
                                  : document_.entry("accessors", jsonOf(primitive)["attributes"][source].get<std::uint64_t>());
        for (const char* gone : {"bufferView", "byteOffset", "sparse", "min", "max"}) accessor.erase(gone);
        accessor["count"] = attribute.vertexCount();
        if (attribute.semantic == "POSITION") addBounds(attribute, accessor);
        return accessor;
    }

    void replace(const Primitive& primitive, const DracoMesh& coded) {
        Json attributes = Json::object(), ids = Json::object();
        for (std::size_t i = 0; i < coded.decoded.attributes.size(); ++i) {
            const MeshAttribute& attribute = coded.decoded.attributes[i];
            attributes[attribute.semantic] = addAccessor(declaredAccessor(primitive, attribute));
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
        json.erase("mode");  // single triangles, also of a strip or a fan
        json["extensions"][kDracoExtension] = {{"bufferView", views_.add(coded.bytes)}, {"attributes", std::move(ids)}};
    }

    /// Returns true for Draco streams that are written plain: all of them, or those that get other light-map UVs, since an encoder would
    /// change the order of their vertices.
    bool isPlain(const Primitive& primitive) const {
        return (isWithoutDraco_ || !uvs_.empty()) && primitive.dracoView && primitive.canCompress;
    }

    /// Writes these primitives. Returns the geometry that each primitive has then.
    std::vector<TriangleMesh> writePlain() {
        std::vector<TriangleMesh> written;
        for (const Primitive& primitive : primitives_) {
            if (isWithoutDraco_ && primitive.dracoView && !primitive.canCompress) failToCode(primitive);
            written.push_back(isPlain(primitive) ? changed(primitive) : primitive.geometry);
            if (isPlain(primitive)) replace(primitive, written.back());
        }
        return written;
    }

    /// Writes the geometry of a primitive plain.
    void replace(const Primitive& primitive, const TriangleMesh& mesh) {
        constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
        Json attributes = Json::object();
        for (const MeshAttribute& attribute : mesh.attributes) {
            Json accessor = declaredAccessor(primitive, attribute);
            // glTF aligns vertex attributes to four bytes.
            const std::size_t bytes = attribute.bytesPerVertex(), stride = (bytes + 3) / 4 * 4;
            std::vector<std::byte> values(stride * attribute.vertexCount());
            for (std::size_t vertex = 0; vertex < attribute.vertexCount(); ++vertex)
                std::copy_n(attribute.values.begin() + static_cast<std::ptrdiff_t>(bytes * vertex), bytes,
                            values.begin() + static_cast<std::ptrdiff_t>(stride * vertex));
            accessor["bufferView"] = views_.add(std::move(values), {{"byteStride", stride}, {"target", kArrayBuffer}});
            attributes[attribute.semantic] = addAccessor(std::move(accessor));
        }
        const std::span<const std::byte> indices = std::as_bytes(std::span(mesh.indices));
        Json accessor = {{"componentType", static_cast<int>(ComponentType::Uint32)}, {"count", mesh.indices.size()}, {"type", "SCALAR"}};
        accessor["bufferView"] = views_.add({indices.begin(), indices.end()}, {{"target", kElementArrayBuffer}});
        Json& json = jsonOf(primitive);
        json["attributes"] = std::move(attributes);
        json["indices"] = addAccessor(std::move(accessor));
        json.erase("mode");
        if (!json.contains("extensions")) return;
        json["extensions"].erase(kDracoExtension);
        if (json["extensions"].empty()) json.erase("extensions");
    }

    /// Removes Draco from the extensions that are used if no primitive has it.
    void forgetDraco() {
        for (const Json& mesh : json_.value("meshes", Json::array()))
            for (const Json& primitive : mesh["primitives"])
                if (primitive.value("extensions", Json::object()).contains(kDracoExtension)) return;
        for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
            if (!json_.contains(list)) continue;
            std::erase(json_[list].get_ref<Json::array_t&>(), kDracoExtension);
            if (json_[list].empty()) json_.erase(list);
        }
    }

    /// Adds the bounds of the stored values: of normalized integers the integers (glTF 2.0, section 3.6.2.5).
    static void addBounds(const MeshAttribute& position, Json& accessor) {
        Json low = Json::array(), high = Json::array();
        for (int axis = 0; axis < position.componentCount; ++axis) {
            double least = HUGE_VAL, most = -HUGE_VAL;
            for (std::size_t vertex = 0; vertex < position.vertexCount(); ++vertex) {
                least = std::min(least, position.stored(vertex, axis));
                most = std::max(most, position.stored(vertex, axis));
            }
            const auto add = [&](Json& bounds, double value) {
                bounds.push_back(position.isFloat() ? Json(static_cast<float>(value)) : Json(static_cast<std::int64_t>(value)));
            };
            add(low, least);
            add(high, most);
        }
        accessor["min"] = std::move(low);
        accessor["max"] = std::move(high);
    }

    void declareDraco() {
        for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
            Json names = json_.value(list, Json::array());
            if (std::find(names.begin(), names.end(), kDracoExtension) == names.end()) names.push_back(kDracoExtension);
            json_[list] = std::move(names);
        }
    }

    const GltfDocument& document_;
    const std::vector<Primitive>& primitives_;
    const ClusterMap* clusters_;  ///< none: vertices get no cluster
    bool isWithoutDraco_;
    std::string oldUvs_;  ///< attribute that keeps light-map UVs which are replaced
    /// New light-map UVs of triangle primitives; empty: they stay. Ordered as the primitives, which lie in one array.
    std::map<const Primitive*, const std::vector<glm::vec2>*> uvs_;
    std::set<std::uint64_t> foreign_;  ///< possible indices in extensions
    Json json_;
    BufferViews views_;
    std::vector<std::uint64_t> freeAccessors_;
};

}  // namespace

BuiltGlb buildGlb(const GltfDocument& document, const std::vector<Primitive>& primitives, const GlbChanges& changes) {
    return GlbBuilder(document, primitives, changes).build(changes.draco);
}

}  // namespace lightcook::formats
