#include "formats/gltf/epic_extension.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <span>

#include "formats/epic_light_maps.h"
#include "formats/file/one_line.h"
#include "formats/lower_extension.h"

namespace lightcook::formats {
namespace {

/// Overhang of a rectangle over its image that rounding explains.
constexpr double kTolerance = 1e-4;

/// Returns the extension's object of a document or a node; null if there is none.
const Json* extensionOf(const Json& owner) {
    const auto extensions = owner.find("extensions");
    if (extensions == owner.end() || !extensions->is_object()) return nullptr;
    const auto found = extensions->find(kEpicExtension);
    return found != extensions->end() && found->is_object() ? &*found : nullptr;
}

std::string inExtension(const std::string& place) {
    return fmt::format("{}, {}", kEpicExtension, place);
}

std::string textOf(const Json& json, const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_string() ? oneLine(found->get<std::string>()) : std::string();
}

/// Returns the four numbers of a member, none of them larger than a limit; nothing for anything else.
std::optional<glm::dvec4> fourNumbers(const Json& json, const char* key, double most) {
    const auto found = json.find(key);
    if (found == json.end() || !found->is_array() || found->size() != 4) return std::nullopt;
    glm::dvec4 numbers(0);
    for (std::size_t i = 0; i < 4; ++i) {
        if (!(*found)[i].is_number()) return std::nullopt;
        const double number = (*found)[i].get<double>();
        if (!(std::abs(number) <= most)) return std::nullopt;
        numbers[static_cast<int>(i)] = number;
    }
    return numbers;
}

/// Returns true if a rectangle of an image has an area and lies within the image.
bool isPartOfImage(const glm::dvec4& scaleBias) {
    for (int axis = 0; axis < 2; ++axis) {
        const double scale = scaleBias[axis], bias = scaleBias[axis + 2];
        if (!(scale > 0) || bias < -kTolerance || bias + scale > 1 + kTolerance) return false;
    }
    return true;
}

/// Returns why a node does not read an image at TEXCOORD_1 of the whole; empty if it does, or draws nothing.
std::string faultOfUvs(const EpicExtension& extension, const EpicExtension::Node& node, std::uint64_t image) {
    if (!node.hasMesh) return {};
    if (!node.part) return "found no light map of a node of `mesh`, expected one for every node that draws";
    const EpicPart& part = extension.parts()[*node.part];
    if (part.image != image)
        return fmt::format("found light map \"{}\" of a node of `mesh`, expected \"{}\"", extension.nameOf(part.image),
                           extension.nameOf(image));
    if (part.texCoord != 1) return fmt::format("found texCoord {} of a node of `mesh`, expected 1", part.texCoord);
    const glm::dvec4& uv = part.coordinateScaleBias;
    if (uv == glm::dvec4(1, 1, 0, 0)) return {};
    return fmt::format("found coordinateScaleBias [{}, {}, {}, {}] of a node of `mesh`, expected [1, 1, 0, 0]", uv.x, uv.y, uv.z, uv.w);
}

}  // namespace

std::string EpicPart::place() const {
    return fmt::format("lightmaps[{}]", index);
}

EpicExtension::EpicExtension(const GltfDocument& document) : document_(document) {
    const Json* const extension = extensionOf(document.json());
    if (extension == nullptr) return;
    const auto lightMaps = extension->find("lightmaps");
    if (lightMaps == extension->end() || !lightMaps->is_array())
        document.fail(ErrorCode::WrongShape, kEpicExtension, "found no list of lightmaps, expected one");
    for (const Json& json : *lightMaps) parts_.push_back(readPart(json, parts_.size()));
    for (const EpicPart& part : parts_) images_.push_back(part.image);
    std::ranges::sort(images_);
    images_.erase(std::unique(images_.begin(), images_.end()), images_.end());
    nameImages();
    readNodes();
}

EpicPart EpicExtension::readPart(const Json& json, std::size_t index) const {
    EpicPart part;
    part.index = index;
    const std::string place = inExtension(part.place());
    if (!json.is_object()) document_.fail(ErrorCode::WrongShape, place, "found no JSON object, expected one");
    const auto texture = json.find("texture");
    if (texture == json.end() || !texture->is_object() || !texture->contains("index"))
        document_.fail(ErrorCode::WrongShape, place, "found no texture, expected one. Did Unreal's export log a missing light map?");
    constexpr const char* kTransform = "KHR_texture_transform";
    if (const auto extensions = texture->find("extensions"); extensions != texture->end() && extensions->contains(kTransform))
        document_.fail(ErrorCode::WrongShape, place,
                       fmt::format("found {} on the texture, expected the rectangle in coordinateScaleBias alone", kTransform));
    part.texCoord = document_.number(*texture, "texCoord", 0, place);
    part.image = imageOf(*texture, part);
    const auto numbers = [&](const char* key, double most, const char* expected) {
        if (!json.contains(key)) document_.fail(ErrorCode::WrongShape, place, fmt::format("found no {}, expected {}", key, expected));
        const auto found = fourNumbers(json, key, most);
        if (!found)
            document_.fail(ErrorCode::WrongShape, place,
                           fmt::format("found {} = {}, expected {}", key, oneLine(json[key].dump()), expected));
        return *found;
    };
    const std::string constants = fmt::format("four numbers from {} to {}", -kMostEpicConstant, kMostEpicConstant);
    part.scale = numbers("lightmapScale", kMostEpicConstant, constants.c_str());
    part.add = numbers("lightmapAdd", kMostEpicConstant, constants.c_str());
    constexpr const char* kRectangle = "[scale x, scale y, bias x, bias y] of a part of the image, within [0, 1]";
    part.coordinateScaleBias = numbers("coordinateScaleBias", 2, kRectangle);
    if (!isPartOfImage(part.coordinateScaleBias)) {
        document_.fail(ErrorCode::WrongShape, place,
                       fmt::format("found coordinateScaleBias = {}, expected {}", json["coordinateScaleBias"].dump(), kRectangle));
    }
    return part;
}

/// Returns the image of a texture that a part names.
std::uint64_t EpicExtension::imageOf(const Json& texture, const EpicPart& part) const {
    const std::string place = inExtension(part.place());
    const std::uint64_t index = document_.number(texture, "index", 0, place);
    const Json& named = document_.entry("textures", index);
    if (!named.contains("source"))
        document_.fail(ErrorCode::WrongShape, fmt::format("textures, entry {}", index), "found no source, expected an image in PNG");
    const std::uint64_t image = document_.number(named, "source", 0, fmt::format("textures, entry {}", index));
    (void)document_.entry("images", image);
    return image;
}

void EpicExtension::readNodes() {
    const auto nodes = document_.json().find("nodes");
    if (nodes == document_.json().end() || !nodes->is_array()) return;
    for (std::size_t index = 0; index < nodes->size(); ++index) {
        const Json& json = (*nodes)[index];
        if (!json.is_object()) continue;
        Node node{index, textOf(json, "name"), json.contains("mesh"), std::nullopt};
        if (const Json* const extension = extensionOf(json); extension != nullptr && extension->contains("lightmap")) {
            const std::string place = fmt::format("nodes, entry {}", index);
            const std::uint64_t part = document_.number(*extension, "lightmap", 0, place);
            if (part >= parts_.size())
                document_.fail(ErrorCode::WrongShape, place,
                               fmt::format("found lightmap {} of {}, expected less than {}", part, kEpicExtension, parts_.size()));
            node.part = part;
        }
        nodes_.push_back(std::move(node));
    }
}

/// Names each image of a part: its own name, or its index where that is empty, shared or a number.
void EpicExtension::nameImages() {
    std::map<std::string, int> counts;
    const auto ownName = [&](std::uint64_t image) { return textOf(document_.entry("images", image), "name"); };
    for (const std::uint64_t image : images_) ++counts[ownName(image)];
    for (const std::uint64_t image : images_) {
        const std::string name = ownName(image);
        const bool isNumber = std::ranges::all_of(name, [](unsigned char c) { return std::isdigit(c) != 0; });
        names_[image] = isNumber || counts[name] > 1 ? fmt::format("{}", image) : name;
    }
}

std::uint64_t EpicExtension::imageNamed(const std::string& name) const {
    if (images_.empty())
        document_.fail(ErrorCode::WrongShape, "",
                       fmt::format("found no light map in the glTF, expected extension {}. Export with Export Lightmaps, after a build of "
                                   "the lighting",
                                   kEpicExtension));
    if (name.empty() && images_.size() == 1) return images_.front();
    if (name.empty())
        document_.fail(ErrorCode::InvalidRequest, "",
                       fmt::format("found {} light maps, expected one of them: {}", images_.size(), choices()));
    for (const std::uint64_t image : images_)
        if (name == nameOf(image) || name == fmt::format("{}", image)) return image;
    document_.fail(ErrorCode::InvalidRequest, "image",
                   fmt::format("found \"{}\", expected a light map of the glTF: {}", oneLine(name), choices()));
}

/// Returns `image = "a" or image = "b"` for errors, and how many more there are.
std::string EpicExtension::choices() const {
    constexpr std::size_t kMostShown = 8;
    std::vector<std::string> shown;
    for (const std::uint64_t image : std::span(images_).first(std::min(kMostShown, images_.size())))
        shown.push_back(fmt::format("image = \"{}\"", nameOf(image)));
    std::string text = fmt::format("{}", fmt::join(shown, " or "));
    if (images_.size() > kMostShown) text += fmt::format(" or {} more (`lightcook info` lists them)", images_.size() - kMostShown);
    return text;
}

bool isGltfFile(const std::filesystem::path& file) {
    const std::string extension = lowerExtension(file);
    return extension == ".gltf" || extension == ".glb";
}

Result<std::vector<std::string>> epicImageNames(const std::filesystem::path& file) {
    return resultOf(file, [&] {
        const GltfDocument document = GltfDocument::withoutBuffers(file);
        const EpicExtension extension(document);
        std::vector<std::string> names;
        for (const std::uint64_t image : extension.images()) names.push_back(extension.nameOf(image));
        return names;
    });
}

std::vector<std::filesystem::path> epicFilesBeside(const std::filesystem::path& file) {
    if (!isGltfFile(file)) return {};
    const auto files = resultOf(file, [&] {
        constexpr std::array kArrays = {"buffers"};
        const GltfDocument document = GltfDocument::withoutBuffers(file);
        std::vector<std::filesystem::path> beside = document.filesBeside(kArrays);
        const EpicExtension extension(document);
        for (const std::uint64_t image : extension.images()) {
            const Json& json = document.entry("images", image);
            const std::string uri = json.value("uri", "");
            if (uri.empty() || uri.starts_with("data:")) continue;
            if (auto path = document.beside(uri)) beside.push_back(std::move(*path));
        }
        return beside;
    });
    return files.value_or(std::vector<std::filesystem::path>());
}

Result<void> checkEpicUvs(const std::filesystem::path& lightMap, const std::filesystem::path& mesh, const std::string& image) {
    if (!isGltfFile(lightMap)) return {};
    const auto checked = resultOf(mesh, [&] {
        const GltfDocument document = GltfDocument::withoutBuffers(mesh);
        const EpicExtension extension(document);
        if (extension.parts().empty()) return true;
        const std::uint64_t chosen = extension.imageNamed(image);
        for (const EpicExtension::Node& node : extension.nodes())
            if (const std::string fault = faultOfUvs(extension, node, chosen); !fault.empty())
                document.fail(ErrorCode::FormatUnsupported,
                              fmt::format("node {}{}", node.index, node.name.empty() ? "" : " '" + node.name + "'"),
                              fmt::format("{}. Remove `mesh`; or write these UVs over the whole light map into TEXCOORD_1, without "
                                          "extension {}",
                                          fault, kEpicExtension));
        return true;
    });
    if (!checked) return tl::make_unexpected(checked.error());
    return {};
}

}  // namespace lightcook::formats
