// Extension EPIC_lightmap_textures of a glTF document. Unreal's exporter writes
//
//   root    lightmaps[] { texture { index, texCoord }, lightmapScale[4], lightmapAdd[4], coordinateScaleBias[4] }
//   node    { lightmap: i }
//
// Several meshes share one image: each has a rectangle of it (coordinateScaleBias) and constants of its own (lightmapScale, lightmapAdd).
// Source: Unreal, Engine/Plugins/Enterprise/GLTFExporter, Converters/GLTFLightMapConverters.cpp and Json/GLTFJsonLightMap.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/gltf/gltf_document.h"

namespace lightcook::formats {

/// An entry of `lightmaps`: the part of an image that a mesh has.
struct EpicPart {
    std::size_t index = 0;    ///< of the entry
    std::uint64_t image = 0;  ///< index in the document's `images`
    std::uint64_t texCoord = 0;
    glm::dvec4 scale{1}, add{0};                 ///< of the stored numbers
    glm::dvec4 coordinateScaleBias{1, 1, 0, 0};  ///< of the UVs: scale x, y; bias x, y

    /// Returns "lightmaps[3]": the place of the entry in errors.
    std::string place() const;
};

/// Largest magnitude of a constant. Unreal's are below 30; sums of these and their powers of two are finite as float.
inline constexpr double kMostEpicConstant = 50;

class EpicExtension {
public:
    /// Reads the extension; throws GltfFault. A document without it has no parts.
    explicit EpicExtension(const GltfDocument& document);

    /// A node that names a part.
    struct Node {
        std::size_t index = 0;
        std::string name;
        bool hasMesh = false;
        std::optional<std::size_t> part;  ///< index of the part
    };

    const std::vector<EpicPart>& parts() const { return parts_; }
    const std::vector<Node>& nodes() const { return nodes_; }
    /// Returns the images of the parts, each once, in the order of the document.
    const std::vector<std::uint64_t>& images() const { return images_; }
    /// Returns the name that chooses an image: see epicImageNames().
    const std::string& nameOf(std::uint64_t image) const { return names_.at(image); }
    /// Returns the image of that name, or of that index in the document; the only one for an empty name. Throws GltfFault.
    std::uint64_t imageNamed(const std::string& name) const;

private:
    EpicPart readPart(const Json& json, std::size_t index) const;
    std::uint64_t imageOf(const Json& texture, const EpicPart& part) const;
    void readNodes();
    void nameImages();
    std::string choices() const;

    const GltfDocument& document_;
    std::vector<EpicPart> parts_;
    std::vector<Node> nodes_;
    std::vector<std::uint64_t> images_;
    std::map<std::uint64_t, std::string> names_;  ///< by image
};

}  // namespace lightcook::formats
