// The errors of some rows of a cooked light map, for a preview: nothing is bounded, and no limit judges them.
#pragma once

#include "pipeline/assets/verdict.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

struct SampledErrors {
    verify::StageError total;     ///< of the whole layout
    int rows = 0, rowsOfMap = 0;  ///< that were compared, of all
};
template <class Fields, Is<SampledErrors> Self>
void describe(Fields& fields, Self& errors) {
    fields.required("total", errors.total, "errors of the whole layout at places of the rows");
    fields.required("rows", errors.rows, "rows that were compared");
    fields.required("rows_of_map", errors.rowsOfMap, "rows of the light map");
}

/// Compares rows that are spread over a light map with the bake; of a small map all of them. Parameters and inputs are those of its
/// verification (LightMapVerifyParameters); the result is SampledErrors.
formats::Result<ActionOutcome> sampleLightMap(const ActionContext& context);

}  // namespace lightcook::pipeline
