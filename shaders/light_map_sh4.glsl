// Layout "sh4": texture "l0", rgb = coefficient 0 over range; texture "ratio", three layers, layer i - 1: rgb = coefficient i over
// coefficient 0, mapped to [0, 1]. Bands 0 and 1 only: band 2 of the result is zero.
#ifndef LIGHTCOOK_LIGHT_MAP_SH4_GLSL
#define LIGHTCOOK_LIGHT_MAP_SH4_GLSL

struct LcSh4Texels {
    vec4 l0;
    vec4 ratio[3];
};
struct LcSh4Constants {
    float range;
    float scale[3];
    float bias[3];
};

LC_FUNCTION LcSh lcLightMapSh4(LcSh4Texels t, LcSh4Constants k) {
    LcSh sh;
    sh.c[0] = k.range * lcRgb(t.l0);
    for (int i = 0; i < 3; ++i) {
        sh.c[i + 1] = sh.c[0] * (k.scale[i] * lcRgb(t.ratio[i]) + lcGrey(k.bias[i]));
    }
    for (int i = 4; i < 9; ++i) {
        sh.c[i] = lcGrey(0.0f);
    }
    return sh;
}

#endif
