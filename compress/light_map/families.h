// Plan and encode functions of the families of layouts. planLightMap and encodeLightMapRows choose among them by
// formats::LightMapLayoutInfo::family; counts of layers come from the table, so that a new layout of a family needs no code. Families
// that are alike share a function; godot, bakery and rnm have no constants to plan; raw and flat are planned and encoded in plan.cpp and
// encode.cpp; basis is planned by planLearnedLightMap. Private to compress/.
#pragma once

#include "compress/light_map.h"
#include "compress/light_map/rows.h"

namespace lightcook::compress::rows {

/// Returns a plan with everything but the constants, its textures as in the table of layouts.
LightMapPlan emptyPlan(formats::LightMapLayout layout, const MeasuredLightMap& map);
/// Returns the power of two that brings the largest value into (8192, 16384]. Encoders that overshoot have two octaves above it, and the
/// 27 octaves below it are free of the subnormals of half floats, whatever the map's unit.
float halfRange(float largest);

/// Adds the constants of the families ratio and sh4.
void planRatio(LightMapPlan& plan, const LightMapMeasure& measure);
/// Adds the constants of family hdr.
void planHdrCoefficients(LightMapPlan& plan, const LightMapMeasure& measure);
/// Adds the constants of family halo3.
void planHalo3(LightMapPlan& plan, const LightMapMeasure& measure);
/// Adds the constants of family unreal.
void planUnreal(LightMapPlan& plan, const LightMapMeasure& measure);
/// Adds the constants of family lit.
void planLit(LightMapPlan& plan, const LightMapMeasure& measure);

EncodedLightMapRows encodeRatio(const LightMapPlan& plan, const Source& source, const EncodeOptions& options);
EncodedLightMapRows encodeHalo3(const LightMapPlan& plan, const Source& source, const EncodeOptions& options);
EncodedLightMapRows encodeHdrCoefficients(const LightMapPlan& plan, const Source& source, const EncodeOptions& options);
/// strip  the rows that `source` was made of: the normals are read
EncodedLightMapRows encodeLinearExit(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source,
                                     const EncodeOptions& options);
EncodedLightMapRows encodeUnreal(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source,
                                 const EncodeOptions& options);
/// strip  the rows that `source` was made of, with tangents
EncodedLightMapRows encodeRnm(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source,
                              const EncodeOptions& options);
EncodedLightMapRows encodeLit(const LightMapPlan& plan, const Source& source, const EncodeOptions& options);
EncodedLightMapRows encodeBasis(const LightMapPlan& plan, const formats::LightMapStrip& strip, const Source& source,
                                const EncodeOptions& options);

}  // namespace lightcook::compress::rows
