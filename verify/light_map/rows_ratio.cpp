// Verification of rows: layouts of coefficient 0 and what is divided by it.
#include "verify/light_map/row_verifier.h"

namespace lightcook::verify::lightmap {

LIGHTCOOK_VERIFY_LAYOUT(Ratio);
LIGHTCOOK_VERIFY_LAYOUT(Zh3);
LIGHTCOOK_VERIFY_LAYOUT(Sh4);
LIGHTCOOK_VERIFY_LAYOUT(Godot);
LIGHTCOOK_VERIFY_LAYOUT(MonoSh);
LIGHTCOOK_VERIFY_LAYOUT(Bakery);

}  // namespace lightcook::verify::lightmap
