// Radially symmetric reflection maps: a 1-D radiance around an axis, filtered by Phong lobes of growing exponent, one row each.
#ifndef LIGHTCOOK_RSRM_GLSL
#define LIGHTCOOK_RSRM_GLSL

// Column: equal steps of cos(angle to the axis), the axis at u = 0. reflection and axis unit.
LC_FUNCTION float lcRsrmU(vec3 reflection, vec3 axis) {
    return clamp(0.5f - 0.5f * dot(reflection, axis), 0.0f, 1.0f);
}
// Fractional row of an exponent where rows grow geometrically: exponent = first * ratio^row.
LC_FUNCTION float lcRsrmRow(float exponent, float first, float ratio) {
    return log2(max(exponent / first, 1.0f)) / log2(ratio);
}
LC_FUNCTION vec2 lcRsrmUv(vec3 reflection, vec3 axis, float row, float rowCount) {
    return vec2(lcRsrmU(reflection, axis), (clamp(row, 0.0f, rowCount - 1.0f) + 0.5f) / rowCount);
}
// Texel times the HDR colour stored beside the map.
LC_FUNCTION vec3 lcRsrm(vec3 texel, vec3 color) {
    return texel * color;
}
// The same of a map of one channel.
LC_FUNCTION vec3 lcRsrmGrey(float texel, vec3 color) {
    return texel * color;
}
// Two maps (two places, two times of day), decoded first.
LC_FUNCTION vec3 lcRsrmBlend(vec3 first, vec3 second, float weight) {
    return mix(first, second, clamp(weight, 0.0f, 1.0f));
}

#endif
