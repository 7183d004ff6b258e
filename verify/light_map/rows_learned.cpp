// Verification of rows: learned layouts with at most one residual layer.
#include "verify/light_map/row_verifier.h"

namespace lightcook::verify::lightmap {

LIGHTCOOK_VERIFY_LAYOUT(Basis<formats::LightMapLayout::Basis3>);
LIGHTCOOK_VERIFY_LAYOUT(Basis<formats::LightMapLayout::Basis4>);
LIGHTCOOK_VERIFY_LAYOUT(Basis<formats::LightMapLayout::Basis8>);

}  // namespace lightcook::verify::lightmap
