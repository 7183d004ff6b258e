// Errors of samples by energy and, where a display is known, by what is seen.
#pragma once

#include <optional>

#include "verify/figures.h"
#include "verify/visible.h"

namespace lightcook::verify {

struct SampleErrors {
    ErrorAccumulator energy;
    std::optional<VisiblePairs> visible;

    /// viewing  none: visible errors are not measured
    SampleErrors(double key, const std::optional<Viewing>& viewing) : energy(key) {
        if (viewing) visible.emplace(*viewing);
    }
    ErrorFigures figures() const {
        ErrorFigures figures = energy.figures();
        if (visible) figures.visible = visible->figures();
        return figures;
    }
};

}  // namespace lightcook::verify
