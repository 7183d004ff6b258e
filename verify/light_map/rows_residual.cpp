// Verification of rows: learned layouts with several residual layers.
#include "verify/light_map/row_verifier.h"

namespace lightcook::verify::lightmap {

LIGHTCOOK_VERIFY_LAYOUT(Basis<formats::LightMapLayout::Basis12>);
LIGHTCOOK_VERIFY_LAYOUT(Basis<formats::LightMapLayout::Basis16>);
LIGHTCOOK_VERIFY_LAYOUT(Basis<formats::LightMapLayout::Basis20>);
LIGHTCOOK_VERIFY_LAYOUT(Basis<formats::LightMapLayout::Basis24>);

}  // namespace lightcook::verify::lightmap
