// Verification of rows: layouts whose textures hold light itself.
#include "verify/light_map/row_verifier.h"

namespace lightcook::verify::lightmap {

LIGHTCOOK_VERIFY_LAYOUT(Raw);
LIGHTCOOK_VERIFY_LAYOUT(Flat);
LIGHTCOOK_VERIFY_LAYOUT(Flat2);
LIGHTCOOK_VERIFY_LAYOUT(Hdr);
LIGHTCOOK_VERIFY_LAYOUT(Hdr2);
LIGHTCOOK_VERIFY_LAYOUT(HdrRgb9e5);

}  // namespace lightcook::verify::lightmap
