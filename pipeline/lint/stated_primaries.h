// Primaries that a source states, among the facts of a light map, a probe or a gradient.
#pragma once

#include "formats/color.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

template <class Fields, Is<formats::StatedPrimaries> Self>
void describe(Fields& fields, Self& primaries) {
    fields.required("chromaticities", primaries.chromaticities, "CIE x, y of red, green, blue and white");
    fields.required("space", primaries.space, "built-in colour space that has them; empty for none");
    fields.required("difference", primaries.difference, "largest difference of an entry of its matrix to BT.2020 and that of the source");
}

}  // namespace lightcook::pipeline
