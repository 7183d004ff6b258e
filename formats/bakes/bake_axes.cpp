#include "formats/bake_axes.h"

#include <cassert>
#include <glm/matrix.hpp>

namespace lightcook::formats {

std::optional<BakeAxes> BakeAxes::fromName(std::string_view name) {
    glm::dmat3 meshFromFile(0);
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t comma = name.find(',');
        if ((comma == std::string_view::npos) != (axis == 2)) return std::nullopt;
        std::string_view part = name.substr(0, comma);
        while (part.starts_with(' ')) part.remove_prefix(1);
        while (part.ends_with(' ')) part.remove_suffix(1);
        const bool isNegative = part.starts_with('-');
        if (isNegative) part.remove_prefix(1);
        const std::size_t component = std::string_view("xyz").find(part);
        if (part.size() != 1 || component == std::string_view::npos) return std::nullopt;
        meshFromFile[static_cast<glm::length_t>(component)][axis] = isNegative ? -1 : 1;
        name.remove_prefix(axis < 2 ? comma + 1 : 0);
    }
    if (glm::determinant(meshFromFile) == 0) return std::nullopt;  // a letter comes twice
    return of(meshFromFile);
}

std::string BakeAxes::name() const {
    std::string text;
    for (int axis = 0; axis < 3; ++axis) {
        if (axis > 0) text += ',';
        if (isNegated(axis)) text += '-';
        text += "xyz"[componentOf(axis)];
    }
    return text;
}

bool BakeAxes::isRotation() const {
    return glm::determinant(matrix()) > 0;
}

glm::dvec3 BakeAxes::operator()(const glm::dvec3& ofFile) const {
    glm::dvec3 turned(0);
    for (int axis = 0; axis < 3; ++axis) turned[axis] = isNegated(axis) ? -ofFile[componentOf(axis)] : ofFile[componentOf(axis)];
    return turned;
}

BakeAxes BakeAxes::then(const BakeAxes& next) const {
    return of(next.matrix() * matrix());
}

BakeAxes BakeAxes::inverse() const {
    return of(glm::transpose(matrix()));
}

glm::dmat3 BakeAxes::matrix() const {
    glm::dmat3 meshFromFile(0);
    for (int axis = 0; axis < 3; ++axis) meshFromFile[componentOf(axis)][axis] = isNegated(axis) ? -1 : 1;
    return meshFromFile;
}

BakeAxes BakeAxes::of(const glm::dmat3& meshFromFile) {
    for (int index = 0; index < kChoices; ++index)
        if (choice(index).matrix() == meshFromFile) return choice(index);
    assert(false && "no signed permutation");
    return {};
}

}  // namespace lightcook::formats
