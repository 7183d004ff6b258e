#include "formats/gltf/node_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "formats/file/one_line.h"
#include "formats/gltf/mesh_placer.h"
#include "formats/gltf/node_placement.h"
#include "formats/gltf/primitive.h"
#include "formats/nearest.h"

namespace lightcook::formats {
namespace {

constexpr std::size_t kNoPlace = SIZE_MAX;

/// Names and parents of the nodes of a document.
class NodeTree {
public:
    explicit NodeTree(const GltfDocument& document) {
        const Json& nodes = document.array("nodes");
        parents_.assign(nodes.size(), kNoPlace);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const auto name = nodes[i].find("name");
            names_.push_back(name != nodes[i].end() && name->is_string() ? name->get<std::string>() : std::string());
            for (const Json& child : nodes[i].value("children", Json::array()))
                if (child.is_number_unsigned() && child.get<std::uint64_t>() < nodes.size()) parents_[child.get<std::size_t>()] = i;
        }
    }
    std::size_t size() const { return names_.size(); }
    std::size_t parent(std::size_t node) const { return parents_[node]; }
    const std::string& name(std::size_t node) const { return names_[node]; }
    const std::vector<std::string>& names() const { return names_; }

    /// Returns "Room/Wall", with the end of a long path.
    std::string path(std::size_t node) const {
        constexpr std::size_t kLongest = 240;
        std::string path = names_[node];
        for (std::size_t depth = 0; (node = parents_[node]) != kNoPlace && path.size() < kLongest && depth < size(); ++depth)
            path.insert(0, names_[node] + "/");
        return path.empty() ? "without a name" : path;
    }
    /// Returns true if a text is the name of a node or the end of its path, of whole names.
    bool fits(std::size_t node, std::string_view text) const {
        for (std::size_t depth = 0; node != kNoPlace && depth < size(); node = parents_[node], ++depth) {
            const std::string& name = names_[node];
            if (text == name) return true;
            // Names may have a slash themselves.
            if (name.empty() || !text.ends_with("/" + name)) return false;
            text.remove_suffix(name.size() + 1);
        }
        return false;
    }

private:
    std::vector<std::string> names_;
    std::vector<std::size_t> parents_;
};

/// Returns the node of a place.
std::size_t nodeOf(const GltfDocument& document, const NodeTree& tree, const NodePlace& place) {
    std::vector<std::size_t> found;
    for (std::size_t node = 0; node < tree.size(); ++node)
        if (!tree.name(node).empty() && tree.fits(node, place.node)) found.push_back(node);
    if (found.size() == 1) return found.front();
    if (found.empty())
        document.fail(ErrorCode::InvalidRequest, "nodes",
                      fmt::format("found no node '{}', expected the name of a node, or the end of its path as in \"Room/Wall\"{}",
                                  oneLine(place.node), nearestHint(place.node, tree.names())));
    document.fail(ErrorCode::InvalidRequest, "nodes",
                  fmt::format("found {} nodes '{}' (the first are '{}' and '{}'), expected one: write the names of the nodes above it too, "
                              "as in \"Room/Wall\", or give the nodes names of their own",
                              found.size(), oneLine(place.node), oneLine(tree.path(found[0])), oneLine(tree.path(found[1]))));
}

}  // namespace

std::vector<std::size_t> placesOfNodes(const GltfDocument& document, const std::vector<NodePlace>& places) {
    const NodeTree tree(document);
    std::map<std::size_t, std::size_t> placeOf;
    for (std::size_t i = 0; i < places.size(); ++i)
        if (const auto [known, isNew] = placeOf.try_emplace(nodeOf(document, tree, places[i]), i); !isNew)
            document.fail(ErrorCode::InvalidRequest, "nodes",
                          fmt::format("found two places of node '{}', expected one", oneLine(tree.path(known->first))));
    std::vector<std::size_t> found;
    for (std::size_t node : drawingNodes(document.json())) {
        found.push_back(kNoPlace);
        for (std::size_t depth = 0; node != kNoPlace && depth < tree.size(); node = tree.parent(node), ++depth)
            if (const auto place = placeOf.find(node); place != placeOf.end()) {
                found.back() = place->second;
                break;
            }
    }
    return found;
}

std::vector<std::string> placeNodes(GltfDocument& document, const std::vector<NodePlace>& places) {
    const std::vector<std::size_t> drawing = drawingNodes(document.json()), placeOf = placesOfNodes(document, places);
    std::set<std::size_t> used(placeOf.begin(), placeOf.end());
    for (std::size_t i = 0; i < places.size(); ++i)
        if (!used.contains(i))
            document.fail(
                ErrorCode::InvalidRequest, "nodes",
                fmt::format("found no mesh at node '{}' or below it, expected one that the light map lies on", oneLine(places[i].node)));
    const std::set<std::uint64_t> lit = meshesWithLightMapUvs(document);
    const NodeTree tree(document);
    std::vector<std::string> unplaced;
    MeshPlacer placer(document);
    for (std::size_t i = 0; i < drawing.size(); ++i) {
        if (placeOf[i] != kNoPlace) {
            const auto& [name, scale, offset] = places[placeOf[i]];
            placer.place(drawing[i], {{scale[0], scale[1]}, {offset[0], offset[1]}});
            continue;
        }
        if (lit.contains(document.json()["nodes"][drawing[i]]["mesh"].get<std::uint64_t>())) unplaced.push_back(tree.path(drawing[i]));
        placer.leaveOut(drawing[i]);
    }
    placer.finish();
    return unplaced;
}

}  // namespace lightcook::formats
