#include "compress/light_map/linear_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

namespace lightcook::compress::rows {

namespace {

/// A white surface shows E(n) = constant + n . linear under lambda_0 = kFirst constant and lambda_1 = kLinear linear: Y of bands 0 and 1
/// times 1 and 2/3 of the cosine.
const double kFirst = 2 * std::sqrt(std::numbers::pi), kLinear = std::sqrt(3 * std::numbers::pi);
/// Factors of A: A_xy = kProduct lambda_4 and alike, A_zz = 2 kSquare lambda_6.
const double kProduct = 0.25 * std::sqrt(15 / std::numbers::pi), kSquare = 0.25 * std::sqrt(5 / std::numbers::pi);

/// Factors of the form: constant^2 has 1, constant (linear . N) twice kCross, |linear|^2 kAlong.
constexpr double kCross = 0.5, kAlong = 1.0 / 3;

using Vector = Eigen::Matrix<double, 4, 1>;  ///< constant, then linear
using Matrix = Eigen::Matrix<double, 4, 4>;
/// The active constraints: linear over the constant along each axis; 0: the axis is free.
using ActiveLimits = glm::dvec3;

Matrix formOf(const glm::dvec3& normal) {
    Matrix form = kAlong * Matrix::Identity();
    form(0, 0) = 1;
    for (int axis = 0; axis < 3; ++axis) form(0, axis + 1) = form(axis + 1, 0) = kCross * normal[axis];
    return form;
}

/// Returns the function nearest to another one under the active constraints.
Vector solved(const Matrix& form, const Vector& wanted, const ActiveLimits& active) {
    Matrix free = Matrix::Identity();  // function = free * (constant, free axes)
    for (int axis = 0; axis < 3; ++axis) {
        if (active[axis] == 0) continue;
        free(axis + 1, axis + 1) = 0;
        free(axis + 1, 0) = active[axis];
    }
    Matrix normal = free.transpose() * form * free;
    for (int axis = 0; axis < 3; ++axis)
        if (active[axis] != 0) normal(axis + 1, axis + 1) = 1;
    const Vector right = free.transpose() * (form * wanted);
    return free * normal.ldlt().solve(right);
}

}  // namespace

LinearExit LinearFit::best(std::span<const glm::vec3> light, int channel) const {
    const auto lambda = [&](std::size_t i) { return static_cast<double>(light[i][channel]); };
    const glm::dvec3& n = normal_;
    const double xy = kProduct * lambda(4), yz = kProduct * lambda(5), xz = kProduct * lambda(7), square = kProduct * lambda(8),
                 zz = kSquare * lambda(6);
    const glm::dvec3 slope((square - zz) * n.x + xy * n.y + xz * n.z, xy * n.x - (square + zz) * n.y + yz * n.z,
                           xz * n.x + yz * n.y + 2 * zz * n.z);
    const double zonal = glm::dot(n, slope);
    return {lambda(0) / kFirst - 3.0 / 16 * zonal,
            glm::dvec3(lambda(3), lambda(1), lambda(2)) / kLinear + 3.0 / 8 * zonal * n + 3.0 / 16 * (slope - zonal * n)};
}

LinearExit LinearFit::within(const LinearExit& best, double extent) const {
    const auto isTooLong = [&](double part, double constant) { return std::abs(part) > extent * constant; };
    const glm::dvec3& l = best.linear;
    if (!isTooLong(l.x, best.constant) && !isTooLong(l.y, best.constant) && !isTooLong(l.z, best.constant)) return best;
    // Active-set method: axes beyond their limit become active constraints, and the others are solved again, until no axis is beyond its
    // limit. If a multiplier has the wrong sign, all 26 active sets are tried.
    const Vector wanted(best.constant, l.x, l.y, l.z);
    const Matrix form = formOf(normal_);
    ActiveLimits active{};
    Vector found = wanted;
    for (bool hasNew = true; hasNew;) {
        hasNew = false;
        for (int axis = 0; axis < 3; ++axis) {
            if (active[axis] != 0 || !isTooLong(found[axis + 1], found[0])) continue;
            active[axis] = found[axis + 1] < 0 ? -extent : extent;
            hasNew = true;
        }
        if (hasNew) found = solved(form, wanted, active);
    }
    const Vector slope = form * (found - wanted);
    bool isOptimal = found[0] >= 0;
    for (int axis = 0; axis < 3; ++axis) isOptimal = isOptimal && active[axis] * slope[axis + 1] <= 0;
    if (!isOptimal) {
        found = Vector::Zero();
        double least = wanted.dot(form * wanted);
        for (int choice = 1; choice < 27; ++choice) {
            for (int axis = 0, rest = choice; axis < 3; ++axis, rest /= 3) active[axis] = extent * (rest % 3 == 2 ? -1 : rest % 3);
            const Vector each = solved(form, wanted, active), error = each - wanted;
            const double cost = error.dot(form * error), limit = each[0] * (1 + 1e-9);
            if (isTooLong(each[1], limit) || isTooLong(each[2], limit) || isTooLong(each[3], limit) || !(cost < least)) continue;
            least = cost;
            found = each;
        }
    }
    if (!(found[0] > 0)) return {};
    return {found[0], glm::dvec3(found[1], found[2], found[3])};
}

glm::dvec3 LinearFit::linearFor(const LinearExit& best, double constant) const {
    return best.linear - kCross / kAlong * (constant - best.constant) * normal_;
}

double LinearFit::constantFor(const LinearExit& best, const glm::dvec3& slope) const {
    const LinearExit unit{1, slope};
    return std::max(product(unit, best) / product(unit, unit), 0.0);
}

glm::dvec3 LinearFit::sharedSlope(const LinearExits& best, const glm::dvec3& constant, const SlopeRange& range) const {
    glm::dvec3 sum(0);
    for (int c = 0; c < 3; ++c) sum += constant[c] * linearFor(best[static_cast<std::size_t>(c)], constant[c]);
    const double square = glm::dot(constant, constant);
    return square > 0 ? glm::clamp(sum / square, range.low, range.high) : glm::dvec3(0);
}

SharedExit LinearFit::shared(const LinearExits& best, const glm::dvec3& start, const SlopeRange& range, int rounds) const {
    SharedExit out{start, glm::dvec3(0)};
    for (int round = 0; round < rounds; ++round) {
        out.slope = sharedSlope(best, out.constant, range);
        for (int c = 0; c < 3; ++c) out.constant[c] = constantFor(best[static_cast<std::size_t>(c)], out.slope);
    }
    return out;
}

double LinearFit::product(const LinearExit& a, const LinearExit& b) const {
    return a.constant * b.constant + kCross * (a.constant * glm::dot(normal_, b.linear) + glm::dot(normal_, a.linear) * b.constant) +
           kAlong * glm::dot(a.linear, b.linear);
}

LinearFit fitAt(const formats::LightMapStrip& strip, const Source& source, int x, int y) {
    const glm::ivec2 owner = source.owner.at(x, y);
    return LinearFit(strip.normal.at(owner.x, owner.y - strip.firstRow));
}

}  // namespace lightcook::compress::rows
