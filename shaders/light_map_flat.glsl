// Layout "flat": texture "exit", rgb = exit radiance of a white surface at the texel's own normal, over range. For scenes without normal
// maps and without specular: there is no direction to ask for.
#ifndef LIGHTCOOK_LIGHT_MAP_FLAT_GLSL
#define LIGHTCOOK_LIGHT_MAP_FLAT_GLSL

struct LcFlatConstants {
    float range;
};

LC_FUNCTION vec3 lcLightMapFlat(vec4 exitTexel, LcFlatConstants k) {
    return k.range * lcRgb(exitTexel);
}

#endif
