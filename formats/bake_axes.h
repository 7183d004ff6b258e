// Axes of the vectors in a file of a bake, against those of its mesh: scene key `axes`. Bakers for Unity write left-handed axes with z
// forward, others have z up.
#pragma once

#include <array>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace lightcook::formats {

/// A signed permutation: which components of a file's vector are x, y and z of the same vector in the axes of the mesh. "x,z,-y": its x,
/// its z, and its y negated, which turns z up into y up.
class BakeAxes {
public:
    /// Six permutations with eight combinations of signs. Number 0 keeps the axes of the file.
    static constexpr int kChoices = 48;
    /// The choice that turns one sign convention into the other: x and y negated.
    static constexpr int kPhaseChoice = 3;
    /// Description of the texts that fromName() takes, for errors and help texts.
    static constexpr std::string_view kExpected = "x, y and z once each, with or without a minus, such as \"-x,y,z\"";

    constexpr BakeAxes() = default;
    /// index  0 .. kChoices - 1
    static constexpr BakeAxes choice(int index) {
        BakeAxes axes;
        axes.index_ = index;
        return axes;
    }
    /// Returns nothing for a text that is no signed permutation. Blanks around the letters are allowed.
    static std::optional<BakeAxes> fromName(std::string_view name);
    /// Returns "-x,y,z".
    std::string name() const;

    constexpr int index() const { return index_; }
    constexpr bool isIdentity() const { return index_ == 0; }
    /// Returns true if the axes of file and mesh have the same handedness.
    bool isRotation() const;
    /// Returns a vector of the file in the axes of the mesh.
    glm::dvec3 operator()(const glm::dvec3& ofFile) const;
    /// Returns the axes that do what this does, and then `next`.
    BakeAxes then(const BakeAxes& next) const;
    BakeAxes inverse() const;
    /// Returns the linear map from the axes of the file to those of the mesh.
    glm::dmat3 matrix() const;

    constexpr bool operator==(const BakeAxes&) const = default;

private:
    static constexpr int kSigns = 8;
    static constexpr std::array<std::array<int, 3>, 6> kPermutations = {{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    static_assert(kChoices == kSigns * kPermutations.size());
    static BakeAxes of(const glm::dmat3& meshFromFile);

    constexpr int componentOf(int axis) const {
        return kPermutations.at(static_cast<std::size_t>(index_ / kSigns)).at(static_cast<std::size_t>(axis));
    }
    constexpr bool isNegated(int axis) const { return (index_ % kSigns >> axis & 1) != 0; }

    int index_ = 0;
};

}  // namespace lightcook::formats
