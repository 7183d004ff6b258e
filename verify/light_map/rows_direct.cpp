// Verification of rows: layouts without tables.
#include "verify/light_map/row_verifier.h"

namespace lightcook::verify::lightmap {

LIGHTCOOK_VERIFY_LAYOUT(Raw);
LIGHTCOOK_VERIFY_LAYOUT(Flat);
LIGHTCOOK_VERIFY_LAYOUT(Luvw);
LIGHTCOOK_VERIFY_LAYOUT(LuvwLinear);
LIGHTCOOK_VERIFY_LAYOUT(Ratio);
LIGHTCOOK_VERIFY_LAYOUT(Zh3);
LIGHTCOOK_VERIFY_LAYOUT(Sh4);
LIGHTCOOK_VERIFY_LAYOUT(Godot);
LIGHTCOOK_VERIFY_LAYOUT(MonoSh);
LIGHTCOOK_VERIFY_LAYOUT(Bakery);
LIGHTCOOK_VERIFY_LAYOUT(Hdr);
LIGHTCOOK_VERIFY_LAYOUT(Hdr2);

}  // namespace lightcook::verify::lightmap
