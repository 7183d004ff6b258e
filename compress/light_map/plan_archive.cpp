// Plans as bytes: they are kept between cooks, and tell apart the strips that were encoded with them.
#include "compress/light_map/basis/model.h"
#include "formats/archive.h"

namespace lightcook::compress {

namespace {

template <class Archive, class Plan>
void membersButBasis(Archive& archive, Plan& plan) {
    archive(plan.layout, plan.target, plan.width, plan.height, plan.mipCount, plan.filter, plan.textures, plan.constants, plan.objective,
            plan.key, plan.vertexBytes);
}

}  // namespace

void LightMapPlan::members(formats::ArchiveWriter& archive, const LightMapPlan& self) {
    membersButBasis(archive, self);
    archive(self.basis ? std::optional(*self.basis) : std::nullopt);
}

void LightMapPlan::members(formats::ArchiveReader& archive, LightMapPlan& self) {
    membersButBasis(archive, self);
    std::optional<BasisModel> basis;
    archive(basis);
    self.basis = basis ? std::make_shared<const BasisModel>(std::move(*basis)) : nullptr;
}

}  // namespace lightcook::compress
