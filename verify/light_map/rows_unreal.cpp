// Verification of rows: layouts whose decode is no polynomial of the texels.
#include "verify/light_map/row_verifier.h"

namespace lightcook::verify::lightmap {

LIGHTCOOK_VERIFY_LAYOUT(UnrealHq);

}  // namespace lightcook::verify::lightmap
