// The curve that lint undoes where it asks whether an image was stored for a display instead of in linear light.
#pragma once

namespace lightcook::pipeline {

inline constexpr double kGamma = 2.2;

}  // namespace lightcook::pipeline
