// Verification of rows: layouts of lengths and colours.
#include "verify/light_map/row_verifier.h"

namespace lightcook::verify::lightmap {

LIGHTCOOK_VERIFY_LAYOUT(Luvw);
LIGHTCOOK_VERIFY_LAYOUT(LuvwLinear);
LIGHTCOOK_VERIFY_LAYOUT(Halo3);
LIGHTCOOK_VERIFY_LAYOUT(Halo3Linear);

}  // namespace lightcook::verify::lightmap
