#include "pipeline/scene/up_axis.h"

#include <array>

#include "formats/vocabulary.h"

namespace lightcook::pipeline {
namespace {

constexpr std::array kUpAxes = {UpAxisInfo{UpAxis::Y, "y", "as in glTF", {0, 1, 0}}, UpAxisInfo{UpAxis::Z, "z", "z points up", {0, 0, 1}},
                                UpAxisInfo{UpAxis::X, "x", "x points up", {1, 0, 0}}};
static_assert(formats::isCompleteTable(kUpAxes, UpAxis::X));

}  // namespace

std::span<const UpAxisInfo> allUpAxes() {
    return kUpAxes;
}

const UpAxisInfo& info(UpAxis axis) {
    return kUpAxes.at(static_cast<std::size_t>(axis));
}

std::vector<std::string> EnumNames<UpAxis>::all() {
    return formats::namesOf(allUpAxes());
}

}  // namespace lightcook::pipeline
