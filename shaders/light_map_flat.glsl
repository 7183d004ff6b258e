// Layouts "flat" and "flat-2": texture "exit", rgb = exit radiance of a white surface at the texel's own normal, over range. Texture
// "second" of flat-2 holds exit + (exact - exit) / share. For scenes without normal maps and without specular: there is no direction to
// ask for.
#ifndef LIGHTCOOK_LIGHT_MAP_FLAT_GLSL
#define LIGHTCOOK_LIGHT_MAP_FLAT_GLSL

struct LcFlatConstants {
    float range;
};

LC_FUNCTION vec3 lcLightMapFlat(vec4 exitTexel, LcFlatConstants k) {
    return k.range * lcRgb(exitTexel);
}

struct LcFlat2Constants {
    float range;
    float share;
};

LC_FUNCTION vec3 lcLightMapFlat2(vec4 exitTexel, vec4 secondTexel, LcFlat2Constants k) {
    return k.range * lcRgb(mix(exitTexel, secondTexel, k.share));
}

#endif
