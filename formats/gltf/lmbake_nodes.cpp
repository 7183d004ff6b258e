// An lmbake names a mesh by its path from the node LightmapGI, "../Room/Wall", and does not say where that node is. The glTF may hold more
// than Godot's scene has below that place (an exported root), or less (the imported file is a part of the scene). So the paths vote:
//
// 1. Each path is compared with each node of its last name, upwards, until one of them ends. If the path ends first, the nodes above are
//    its base; if the nodes end first, the names before are what the glTF stands below in Godot's scene.
// 2. Of these places the one counts that most paths have with the same number of "..", of equal ones the one with fewest nodes above. Where
//    two are equal in that too, nothing says which is meant, and none of these paths is matched.
// 3. A path and a node are matched if nothing else has either of them.
#include "formats/gltf/lmbake_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <tuple>
#include <utility>

#include "formats/file/one_line.h"
#include "formats/gltf/node_placement.h"
#include "formats/gltf/primitive.h"

namespace lightcook::formats {
namespace {

constexpr std::size_t kNoNode = SIZE_MAX;
constexpr const char* kUvs = "TEXCOORD_1";
/// Comparisons of a path with a node, beyond which a file is no scene: nodes of one name are few.
constexpr std::size_t kMostComparisons = 1u << 22;
/// Primitives of meshes that are copied for further nodes, and their UVs: a small file may have a mesh that many nodes draw.
constexpr std::size_t kMostCopies = 1u << 20, kMostUvBytes = std::size_t{256} << 20, kMostUvSharing = 64;

/// Returns a node's name as Godot has it, which keeps some characters for paths.
std::string nameInGodot(const Json& node) {
    const auto found = node.find("name");
    std::string name = found != node.end() && found->is_string() ? found->get<std::string>() : std::string();
    for (char& character : name)
        if (std::string_view(".:@/\"%").find(character) != std::string_view::npos) character = '_';
    return name;
}

/// Place in a glTF at which the paths of an lmbake begin: a node, or its roots, which `prefix` leads to in Godot's scene.
struct Base {
    std::size_t depth = 0;       ///< nodes above
    std::size_t node = kNoNode;  ///< none: the roots
    std::string prefix = {};
    auto order() const { return std::tie(depth, prefix, node); }
    bool operator<(const Base& other) const { return order() < other.order(); }
};

/// Finds the node of each path.
class NodeFinder {
public:
    NodeFinder(const GltfDocument& document, const Lmbake& lmbake, std::span<const std::size_t> drawing)
        : document_(document), lmbake_(lmbake), userOf_(drawing.size(), kNoNode), drawing_(drawing) {
        const Json& nodes = document.array("nodes");
        parents_.assign(nodes.size(), kNoNode);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            names_.push_back(nameInGodot(nodes[i]));
            for (const Json& child : nodes[i].value("children", Json::array())) parents_[child.get<std::size_t>()] = i;
        }
        for (std::size_t i = 0; i < drawing.size(); ++i) byName_[names_[drawing[i]]].push_back(i);
    }

    /// Returns the user of each drawing node; kNoNode: it has none.
    std::vector<std::size_t> find() {
        for (std::size_t user = 0; user < lmbake_.users.size(); ++user) compare(user);
        for (const auto& [ups, bases] : votes_)
            if (const auto best = mostVoted(bases)) take(bases.at(*best));
        for (std::size_t& user : userOf_)
            if (user == kShared) user = kNoNode;
        return userOf_;
    }

    /// Returns "Room/Wall", with the end of a long path.
    std::string pathOf(std::size_t node) const {
        constexpr std::size_t kLongest = 240;
        std::string path = names_[node];
        while ((node = parents_[node]) != kNoNode && path.size() < kLongest) path.insert(0, names_[node] + "/");
        if (path.size() > kLongest) path = "..." + path.substr(path.size() - kLongest);
        return path.empty() ? fmt::format("node {}", node) : path;
    }

private:
    static constexpr std::size_t kShared = kNoNode - 1;
    struct Pair {
        std::size_t user, node;  ///< node: index in `drawing`
    };

    void compare(std::size_t user) {
        const LmbakeUser& named = lmbake_.users[user];
        if (named.subInstance >= 0) return;  // a node of glTF has one mesh
        std::span<const std::string> path = named.path;
        const auto isUp = [](const std::string& name) { return name == ".."; };
        const auto ups = static_cast<std::size_t>(std::ranges::find_if_not(path, isUp) - path.begin());
        path = path.subspan(ups);
        if (path.empty()) return;
        const auto sameName = byName_.find(path.back());
        if (sameName == byName_.end()) return;
        constexpr std::size_t kBytesAtOnce = 64;
        std::size_t bytes = kBytesAtOnce;
        for (const std::string& name : path) bytes += name.size();
        comparisons_ += sameName->second.size() * (bytes / kBytesAtOnce);
        if (comparisons_ > kMostComparisons)
            document_.fail(ErrorCode::FormatUnsupported, "nodes",
                           fmt::format("found more than {} pairs of a node and an entry of the lmbake with the same name, expected nodes "
                                       "with names of their own",
                                       kMostComparisons));
        for (const std::size_t index : sameName->second)
            if (const auto base = baseOf(path, drawing_[index])) votes_[ups][*base].push_back({user, index});
    }

    std::optional<Base> baseOf(std::span<const std::string> path, std::size_t node) const {
        std::size_t left = path.size();
        for (; left > 0 && node != kNoNode; --left, node = parents_[node])
            if (path[left - 1] != names_[node]) return std::nullopt;
        Base base;
        base.node = node;
        for (; node != kNoNode; node = parents_[node]) ++base.depth;
        for (const std::string& name : path.first(left)) base.prefix += name + "/";
        return base;
    }

    static std::optional<Base> mostVoted(const std::map<Base, std::vector<Pair>>& bases) {
        std::optional<Base> best;
        std::size_t most = 0;
        bool isTied = false;
        for (const auto& [base, pairs] : bases) {
            std::set<std::size_t> users;
            for (const Pair& pair : pairs) users.insert(pair.user);
            // In the order of depth: a later one is no better if it has as many.
            const bool isEqual = best && users.size() == most && base.depth == best->depth;
            if (users.size() > most) {
                best = base;
                most = users.size();
                isTied = false;
            } else if (isEqual) {
                isTied = true;
            }
        }
        return isTied ? std::nullopt : best;
    }

    void take(const std::vector<Pair>& pairs) {
        std::map<std::size_t, std::size_t> nodesOfUser;
        for (const Pair& pair : pairs) ++nodesOfUser[pair.user];
        for (const Pair& pair : pairs) {
            std::size_t& user = userOf_[pair.node];
            user = user == kNoNode && nodesOfUser[pair.user] == 1 ? pair.user : kShared;
        }
    }

    const GltfDocument& document_;
    const Lmbake& lmbake_;
    std::vector<std::size_t> userOf_;
    std::span<const std::size_t> drawing_;
    std::vector<std::string> names_;
    std::vector<std::size_t> parents_;
    std::map<std::string, std::vector<std::size_t>> byName_;          ///< indices in drawing_
    std::map<std::size_t, std::map<Base, std::vector<Pair>>> votes_;  ///< by the number of ".."
    std::size_t comparisons_ = 0;
};

/// Gives meshes of a document their places in the map.
class MeshPlacer {
public:
    MeshPlacer(GltfDocument& document, int sliceCount) : document_(document), json_(document.changedJson()), sliceCount_(sliceCount) {
        if (!json_.contains("bufferViews")) json_["bufferViews"] = Json::array();  // none of sparse accessors alone
    }

    /// Gives a node a mesh of its own in a rectangle.
    void place(std::size_t node, const LmbakeUser& user) {
        Json& mesh = ownMesh(node, false);
        for (Json& primitive : mesh["primitives"]) {
            Json& attributes = primitive["attributes"];
            if (!attributes.contains(kUvs)) continue;
            attributes[kUvs] = placedUvs(attributes[kUvs].get<std::uint64_t>(), user);
        }
    }
    /// Gives a node a mesh without light-map UVs, which it shares with others that have none.
    void strip(std::size_t node) {
        for (Json& primitive : ownMesh(node, true)["primitives"]) primitive["attributes"].erase(kUvs);
    }
    /// Adds the buffer of the new UVs.
    void finish() {
        if (values_.empty()) return;
        const std::uint64_t buffer = document_.addBuffer(std::move(values_));
        for (const std::size_t view : views_) json_["bufferViews"][view]["buffer"] = buffer;
    }

private:
    /// Returns the mesh that a node gets: the document's for the first node, a copy of it for each further one.
    Json& ownMesh(std::size_t node, bool isShared) {
        Json& index = json_["nodes"][node]["mesh"];
        const auto source = index.get<std::size_t>();
        const auto known = stripped_.find(source);
        std::size_t own = source;
        if (isShared && known != stripped_.end()) {
            own = known->second;
        } else if (const auto [original, isFirst] = originals_.try_emplace(source, json_["meshes"][source]); !isFirst) {
            own = json_["meshes"].size();
            copies_ += original->second["primitives"].size();
            if (copies_ > kMostCopies)
                document_.fail(ErrorCode::FormatUnsupported, fmt::format("node {}", node),
                               fmt::format("found nodes that need more than {} primitives of their own, expected less", kMostCopies));
            json_["meshes"].push_back(original->second);
        }
        if (isShared) stripped_[source] = own;
        index = own;
        return json_["meshes"][own];
    }

    /// Returns the accessor of the UVs of another one in a rectangle.
    std::size_t placedUvs(std::uint64_t accessor, const LmbakeUser& user) {
        const auto [known, isNew] = placed_.try_emplace({accessor, &user}, 0);
        if (!isNew) return known->second;
        const MeshAttribute uvs = document_.readAccessor(accessor, kUvs);
        const std::size_t first = values_.size(), count = uvs.vertexCount(), most = kMostUvBytes + kMostUvSharing * document_.fileBytes();
        if (first + count * sizeof(std::array<float, 2>) > most)
            document_.fail(ErrorCode::FormatUnsupported, fmt::format("accessor {} ({})", accessor, kUvs),
                           fmt::format("found nodes that need more than {} MiB of light-map UVs, expected less in a file of {} bytes",
                                       most >> 20, document_.fileBytes()));
        std::vector<std::array<float, 2>> made;
        const glm::dvec4& at = user.rectangle;
        for (std::size_t vertex = 0; vertex < count; ++vertex) {
            const glm::dvec3 uv = uvs.at(vertex);
            made.push_back({static_cast<float>(at.x + uv.x * at.z), static_cast<float>((user.slice + at.y + uv.y * at.w) / sliceCount_)});
        }
        const std::span<const std::byte> bytes = std::as_bytes(std::span(made));
        values_.insert(values_.end(), bytes.begin(), bytes.end());
        constexpr unsigned kArrayBuffer = 34962;  // readers take whole numbers that are unsigned
        views_.push_back(json_["bufferViews"].size());
        json_["bufferViews"].push_back({{"byteOffset", first}, {"byteLength", bytes.size()}, {"target", kArrayBuffer}});
        known->second = json_["accessors"].size();
        json_["accessors"].push_back({{"bufferView", views_.back()},
                                      {"componentType", static_cast<unsigned>(ComponentType::Float32)},
                                      {"count", count},
                                      {"type", "VEC2"}});
        return known->second;
    }

    GltfDocument& document_;
    Json& json_;
    int sliceCount_;
    std::map<std::size_t, Json> originals_;                                      ///< the document's meshes that nodes have, as they were
    std::map<std::size_t, std::size_t> stripped_;                                ///< by the document's mesh: the one without light-map UVs
    std::map<std::pair<std::uint64_t, const LmbakeUser*>, std::size_t> placed_;  ///< accessors
    std::vector<std::byte> values_;                                              ///< of the new UVs
    std::vector<std::size_t> views_;                                             ///< of these
    std::size_t copies_ = 0;
};

}  // namespace

LmbakeMatch placeNodes(GltfDocument& document, const Lmbake& lmbake, const std::filesystem::path& source) {
    const std::set<std::uint64_t> lit = meshesWith(document, kUvs);
    std::vector<std::size_t> drawing = drawingNodes(document.json());
    std::erase_if(drawing, [&](std::size_t node) { return !lit.contains(document.json()["nodes"][node]["mesh"].get<std::uint64_t>()); });
    NodeFinder finder(document, lmbake, drawing);
    const std::vector<std::size_t> userOf = finder.find();
    LmbakeMatch match;
    std::vector<bool> isRead(lmbake.users.size(), false);
    MeshPlacer placer(document, lmbake.sliceCount());
    for (std::size_t i = 0; i < drawing.size(); ++i) {
        if (userOf[i] == kNoNode) continue;
        placer.place(drawing[i], lmbake.users[userOf[i]]);
        isRead[userOf[i]] = true;
        ++match.placed;
    }
    for (std::size_t i = 0; i < drawing.size(); ++i) {
        if (userOf[i] != kNoNode) continue;
        match.unplaced.push_back(finder.pathOf(drawing[i]));
        placer.strip(drawing[i]);
    }
    for (std::size_t user = 0; user < lmbake.users.size(); ++user)
        if (!isRead[user]) match.unread.push_back(lmbake.users[user].name());
    if (match.placed == 0 && !drawing.empty())
        document.fail(
            ErrorCode::WrongShape, "nodes",
            fmt::format("found none of the {} nodes of {} (the first is '{}') among the {} with light-map UVs (the first is '{}'), "
                        "expected the scene that Godot baked. UVs in the whole map already? Set lmbake = \"{}\"",
                        lmbake.users.size(), source.filename().string(), match.unread.empty() ? "" : oneLine(match.unread.front()),
                        drawing.size(), oneLine(match.unplaced.front()), kNoLmbake));
    placer.finish();
    return match;
}

}  // namespace lightcook::formats
