// Layout "raw": texture "sh", nine layers, rgb = coefficient i over range.
#ifndef LIGHTCOOK_LIGHT_MAP_RAW_GLSL
#define LIGHTCOOK_LIGHT_MAP_RAW_GLSL

struct LcRawTexels {
    vec4 sh[9];
};
struct LcRawConstants {
    float range;
};

LC_FUNCTION LcSh lcLightMapRaw(LcRawTexels t, LcRawConstants k) {
    LcSh sh;
    for (int i = 0; i < 9; ++i) {
        sh.c[i] = k.range * lcRgb(t.sh[i]);
    }
    return sh;
}

#endif
