// Errors of any light map against its bake, from coefficients alone: whatever layout, codec or engine they came out of. Texel centres only,
// the same shading and the same sums as LightMapVerifier's, which knows our own layouts.
#pragma once

#include <memory>

#include "formats/error.h"
#include "formats/image.h"
#include "formats/light_map.h"
#include "verify/figures.h"
#include "verify/light_map.h"

namespace lightcook::verify {

class LightMapScore {
public:
    struct Errors {
        ErrorAccumulator diffuse{1}, specular{1};
        void merge(const Errors& other);
    };

    /// Refuses shading without normals, views, m or F0, or with values out of range.
    /// key  of the reference (LightMapKey)
    static formats::Result<LightMapScore> create(const LightMapShading& shading, double key);
    LightMapScore(LightMapScore&&) noexcept;
    LightMapScore& operator=(LightMapScore&&) noexcept;
    ~LightMapScore();

    /// Errors of rows [firstRow, firstRow + result.height) of the map, which the reference must hold; merged in the order of rows they are
    /// the map's. Pure; safe to call from several threads.
    /// result  as wide as the reference: incident radiance, world frame, canonical phase
    Errors score(const formats::LightMapStrip& reference, formats::ImageView<const lighting::ShRgb> result, int firstRow) const;

private:
    struct State;
    explicit LightMapScore(std::unique_ptr<const State> state);
    std::unique_ptr<const State> state_;
};

}  // namespace lightcook::verify
