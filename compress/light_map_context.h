// Rows around the encoded ones that the encoder of a light map reads.
#pragma once

namespace lightcook::compress {

/// Rows beyond the encoded ones, on either side, that encodeLightMapRows reads: padding is solved for the filter, and each row depends on
/// those around it.
inline constexpr int kLightMapContextRows = 10;

}  // namespace lightcook::compress
