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
#include "formats/gltf/mesh_placer.h"
#include "formats/gltf/node_placement.h"
#include "formats/gltf/primitive.h"

namespace lightcook::formats {
namespace {

constexpr std::size_t kNoNode = SIZE_MAX;
/// Comparisons of a path with a node, beyond which a file is no scene: nodes of one name are few.
constexpr std::size_t kMostComparisons = 1u << 22;

/// Returns the place of a mesh of the bake in the whole map: of n slices, slice i has the V coordinates (i + v) / n.
UvRectangle rectangleOf(const LmbakeUser& user, int sliceCount) {
    const glm::dvec4& at = user.rectangle;
    return {{at.z, at.w / sliceCount}, {at.x, (user.slice + at.y) / sliceCount}};
}

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

}  // namespace

LmbakeMatch placeNodes(GltfDocument& document, const Lmbake& lmbake, const std::filesystem::path& source) {
    const std::set<std::uint64_t> lit = meshesWithLightMapUvs(document);
    std::vector<std::size_t> drawing = drawingNodes(document.json());
    std::erase_if(drawing, [&](std::size_t node) { return !lit.contains(document.json()["nodes"][node]["mesh"].get<std::uint64_t>()); });
    NodeFinder finder(document, lmbake, drawing);
    const std::vector<std::size_t> userOf = finder.find();
    LmbakeMatch match;
    std::vector<bool> isRead(lmbake.users.size(), false);
    MeshPlacer placer(document);
    for (std::size_t i = 0; i < drawing.size(); ++i) {
        if (userOf[i] == kNoNode) continue;
        placer.place(drawing[i], rectangleOf(lmbake.users[userOf[i]], lmbake.sliceCount()));
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
