#include "formats/gltf/light_map_uvs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "formats/file/one_line.h"
#include "formats/gltf/mesh_placer.h"

namespace lightcook::formats {
namespace {

constexpr const char *kTextureTransform = "KHR_texture_transform", *kLightMap = "MOZ_lightmap";

std::string uvSet(std::uint64_t set) {
    return fmt::format("TEXCOORD_{}", set);
}

/// Returns a member of an object, or null.
const Json* memberOf(const Json* owner, const char* key) {
    if (owner == nullptr || !owner->is_object()) return nullptr;
    const auto found = owner->find(key);
    return found == owner->end() ? nullptr : &*found;
}
std::optional<std::uint64_t> wholeOf(const Json* owner, const char* key) {
    const Json* const found = memberOf(owner, key);
    return found != nullptr && found->is_number_unsigned() ? std::optional(found->get<std::uint64_t>()) : std::nullopt;
}
const Json* transformOf(const Json& texture) {
    return memberOf(memberOf(&texture, "extensions"), kTextureTransform);
}

/// Returns the two numbers of a member, or others without it.
glm::dvec2 pairOf(const Json* owner, const char* key, const glm::dvec2& otherwise) {
    const Json* const found = memberOf(owner, key);
    if (found == nullptr || !found->is_array() || found->size() != 2 || !(*found)[0].is_number() || !(*found)[1].is_number())
        return otherwise;
    return {(*found)[0].get<double>(), (*found)[1].get<double>()};
}

UvTransform uvTransformOf(const Json& texture) {
    const Json* const json = transformOf(texture);
    if (json == nullptr) return {};
    const glm::dvec2 scale = pairOf(json, "scale", glm::dvec2(1));
    const Json* const turn = memberOf(json, "rotation");
    const double angle = turn != nullptr && turn->is_number() ? turn->get<double>() : 0.0;
    const double c = std::cos(angle), s = std::sin(angle);
    return {glm::dmat2(c * scale.x, -s * scale.x, s * scale.y, c * scale.y), pairOf(json, "offset", glm::dvec2(0))};
}

/// Returns the UV set of a texture; nothing for one that does not name it.
std::optional<std::uint64_t> namedSet(const Json& texture) {
    const auto other = wholeOf(transformOf(texture), "texCoord");
    return other ? other : wholeOf(&texture, "texCoord");
}
std::uint64_t setOf(const Json& texture) {
    return namedSet(texture).value_or(0);
}

/// Calls visit(key, texture) for each texture that a material names, also in extensions.
template <class JsonOrConst, class Visit>
void visitTextures(JsonOrConst& material, const Visit& visit) {
    if (!material.is_object()) return;
    for (auto& [key, value] : material.items()) {
        if (key == "extras" || !value.is_object()) continue;
        if (value.contains("index"))
            visit(key, value);
        else
            visitTextures(value, visit);
    }
}

const Json* materialOf(const GltfDocument& document, const Json& primitive) {
    const auto index = wholeOf(&primitive, "material");
    const Json* const materials = memberOf(&document.json(), "materials");
    if (!index || materials == nullptr || !materials->is_array() || *index >= materials->size()) return nullptr;
    return &(*materials)[*index];
}

bool hasSet(const Json& primitive, std::uint64_t set) {
    return memberOf(memberOf(&primitive, "attributes"), uvSet(set).c_str()) != nullptr;
}

/// Returns true if a UV set of a primitive is stored as integers.
bool isQuantized(const GltfDocument& document, const Json& primitive, std::uint64_t set) {
    const auto accessor = wholeOf(memberOf(&primitive, "attributes"), uvSet(set).c_str());
    const Json* const accessors = memberOf(&document.json(), "accessors");
    if (!accessor || accessors == nullptr || !accessors->is_array() || *accessor >= accessors->size()) return false;
    const auto type = wholeOf(&(*accessors)[*accessor], "componentType");
    return type && *type != static_cast<std::uint64_t>(ComponentType::Float32);
}

bool isOfGltfpack(const GltfDocument& document) {
    const Json* const generator = memberOf(memberOf(&document.json(), "asset"), "generator");
    return generator != nullptr && generator->is_string() && generator->get<std::string>().starts_with("gltfpack");
}

/// Returns the transform that textures of quantized UVs share, which brings these to their range; identity if there is none.
UvTransform dequantization(const GltfDocument& document, const Json& primitive, const Json& material) {
    const bool takesAll = isOfGltfpack(document);
    std::vector<UvTransform> found;
    visitTextures(material, [&](const std::string& key, const Json& texture) {
        if (key == kLightMap || (setOf(texture) != 1 && !(takesAll && isQuantized(document, primitive, setOf(texture))))) return;
        found.push_back(uvTransformOf(texture));
    });
    const auto differs = [&](const UvTransform& each) { return each != found.front(); };
    return found.empty() || std::ranges::any_of(found, differs) ? UvTransform() : found.front();
}

bool isTriangles(const Json& primitive) {
    constexpr std::uint64_t kLone = 4, kStrip = 5, kFan = 6;
    const std::uint64_t mode = wholeOf(&primitive, "mode").value_or(kLone);
    return mode == kLone || mode == kStrip || mode == kFan;
}

/// Calls visit(primitive, mesh, index) for each triangle primitive.
template <class JsonOrConst, class Visit>
void visitPrimitives(JsonOrConst& gltf, const Visit& visit) {
    if (!gltf.contains("meshes") || !gltf["meshes"].is_array()) return;
    for (std::size_t mesh = 0; mesh < gltf["meshes"].size(); ++mesh) {
        auto& owner = gltf["meshes"][mesh];
        if (!owner.is_object() || !owner.contains("primitives") || !owner["primitives"].is_array()) continue;
        for (std::size_t i = 0; i < owner["primitives"].size(); ++i)
            if (owner["primitives"][i].is_object() && isTriangles(owner["primitives"][i])) visit(owner["primitives"][i], mesh, i);
    }
}

/// Change of a material whose textures read UV sets that move.
struct SetChange {
    LightMapUvs lightMap;
    std::uint64_t oldSet = 1;  ///< where TEXCOORD_1 goes
    auto order() const {
        const UvTransform& t = lightMap.transform;
        return std::tuple(lightMap.set, oldSet, t.matrix[0][0], t.matrix[0][1], t.matrix[1][0], t.matrix[1][1], t.offset.x, t.offset.y);
    }
    bool operator<(const SetChange& other) const { return order() < other.order(); }
};

/// Sets the UV set of a texture.
void nameSet(Json& texture, std::uint64_t set) {
    texture["texCoord"] = set;
    if (Json* const transform = const_cast<Json*>(transformOf(texture)); transform != nullptr && transform->contains("texCoord"))
        (*transform)["texCoord"] = set;
}

void removeTransform(Json& texture) {
    if (!texture.contains("extensions")) return;
    texture["extensions"].erase(kTextureTransform);
    if (texture["extensions"].empty()) texture.erase("extensions");
}

/// Returns true for a texture whose transform is in the light-map UVs.
bool isInUvs(const std::string& key, const Json& texture, const LightMapUvs& uvs) {
    if (key == kLightMap) return true;
    return uvs.set == 1 && setOf(texture) == 1 && uvTransformOf(texture) == uvs.transform;
}

bool mentions(const Json& json, const char* extension) {
    if (json.is_array()) return std::ranges::any_of(json, [&](const Json& each) { return mentions(each, extension); });
    if (!json.is_object()) return false;
    for (const auto& [key, value] : json.items())
        if (key != "extensionsUsed" && key != "extensionsRequired" && (key == extension || mentions(value, extension))) return true;
    return false;
}

/// Stores the light-map UVs of a document.
class UvStore {
public:
    explicit UvStore(GltfDocument& document) : document_(document), json_(document.changedJson()), added_(document) {}

    void run() {
        visitPrimitives(json_, [&](Json& primitive, std::size_t mesh, std::size_t index) {
            const LightMapUvs uvs = lightMapUvsOf(document_, primitive);
            const auto material = wholeOf(&primitive, "material");
            std::optional<SetChange> change;
            if (!uvs.isPlain()) change = store(primitive, uvs, fmt::format("mesh {}, primitive {}", mesh, index));
            if (material) users_[*material].push_back({&primitive, change});
        });
        for (const auto& [material, users] : users_) changeMaterial(material, users);
        added_.finish();
        if (mentions(json_, kTextureTransform)) return;
        for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
            if (!json_.contains(list)) continue;
            std::erase(json_[list].get_ref<Json::array_t&>(), Json(kTextureTransform));
            if (json_[list].empty()) json_.erase(list);
        }
    }

private:
    struct User {
        Json* primitive;
        std::optional<SetChange> change;
    };

    SetChange store(Json& primitive, const LightMapUvs& uvs, const std::string& place) {
        Json& attributes = primitive["attributes"];
        const std::string from = uvSet(uvs.set);
        if (!attributes.contains(from))
            document_.fail(ErrorCode::WrongShape, place,
                           fmt::format("found no {}, which {} of its material names, expected the light-map UVs", from, kLightMap));
        SetChange change{uvs, 1};
        const Json* const material = materialOf(document_, primitive);
        bool isNeeded = uvs.set != 1;
        if (material != nullptr)
            visitTextures(*material, [&](const std::string& key, const Json& texture) {
                isNeeded |= setOf(texture) == 1 && !isInUvs(key, texture, uvs);
            });
        const std::uint64_t accessor = attributes[from].get<std::uint64_t>();
        if (attributes.contains(kLightMapUvs) && isNeeded) {
            change.oldSet = 2;
            while (attributes.contains(uvSet(change.oldSet))) ++change.oldSet;
            attributes[uvSet(change.oldSet)] = attributes[kLightMapUvs];
        }
        attributes[kLightMapUvs] = uvs.transform.isIdentity() ? accessor : transformed(accessor, from, change);
        return change;
    }

    std::size_t transformed(std::uint64_t accessor, const std::string& semantic, const SetChange& change) {
        const UvTransform& transform = change.lightMap.transform;
        const auto [known, isNew] = made_.try_emplace({accessor, SetChange{{1, transform}, 1}}, 0);
        if (!isNew) return known->second;
        const MeshAttribute uvs = document_.readAccessor(accessor, semantic);
        std::vector<glm::vec2> values;
        for (std::size_t vertex = 0; vertex < uvs.vertexCount(); ++vertex) values.emplace_back(transform(glm::dvec2(uvs.at(vertex))));
        known->second = added_.add(values);
        return known->second;
    }

    /// Changes the textures of a material: in a copy of it where other primitives need it as it is, or otherwise.
    void changeMaterial(std::size_t index, const std::vector<User>& users) {
        std::map<SetChange, std::size_t> changed;
        const bool isShared = std::ranges::any_of(users, [](const User& user) { return !user.change; });
        const Json original = json_["materials"][index];
        for (const User& user : users) {
            if (!user.change) continue;
            const auto [known, isNew] = changed.try_emplace(*user.change, index);
            if (isNew) {
                Json material = original;
                visitTextures(material, [&](const std::string& key, Json& texture) { changeTexture(key, texture, *user.change); });
                if (material == original) {
                    known->second = index;
                } else if (!isShared && changed.size() == 1) {
                    json_["materials"][index] = std::move(material);
                } else {
                    known->second = json_["materials"].size();
                    json_["materials"].push_back(std::move(material));
                }
            }
            if (known->second != index) (*user.primitive)["material"] = known->second;
        }
    }

    static void changeTexture(const std::string& key, Json& texture, const SetChange& change) {
        if (isInUvs(key, texture, change.lightMap)) {
            removeTransform(texture);
            texture["texCoord"] = 1u;
        } else if (setOf(texture) == 1) {
            nameSet(texture, change.oldSet);
        }
    }

    GltfDocument& document_;
    Json& json_;
    AddedUvs added_;
    std::map<std::size_t, std::vector<User>> users_;                   ///< by material
    std::map<std::pair<std::uint64_t, SetChange>, std::size_t> made_;  ///< accessors
};

}  // namespace

LightMapUvs lightMapUvsOf(const GltfDocument& document, const Json& primitive) {
    const Json* const material = materialOf(document, primitive);
    if (material == nullptr || (!hasSet(primitive, 0) && !hasSet(primitive, 1))) return {};
    if (const Json* const lightMap = memberOf(memberOf(material, "extensions"), kLightMap); lightMap != nullptr && lightMap->is_object())
        // Loaders that know no other set take the second one where the extension does not say.
        return {namedSet(*lightMap).value_or(hasSet(primitive, 1) ? 1 : 0), uvTransformOf(*lightMap)};
    if (!isQuantized(document, primitive, 1)) return {};
    return {1, dequantization(document, primitive, *material)};
}

bool hasLightMapUvs(const GltfDocument& document, const Json& primitive) {
    return hasSet(primitive, lightMapUvsOf(document, primitive).set);
}

bool hasOtherLightMapUvs(const GltfDocument& document) {
    bool found = false;
    visitPrimitives(document.json(),
                    [&](const Json& primitive, std::size_t, std::size_t) { found |= !lightMapUvsOf(document, primitive).isPlain(); });
    return found;
}

void storeLightMapUvs(GltfDocument& document) {
    UvStore(document).run();
}

}  // namespace lightcook::formats
