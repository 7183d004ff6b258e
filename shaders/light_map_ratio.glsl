// Layout "ratio": texture "l0", rgb = coefficient 0 over range; texture "ratio", eight layers, layer i - 1: rgb = coefficient i over
// coefficient 0, mapped to [0, 1]. Light that is nowhere negative keeps band 1 within sqrt 3 and band 2 within sqrt 5 of it.
#ifndef LIGHTCOOK_LIGHT_MAP_RATIO_GLSL
#define LIGHTCOOK_LIGHT_MAP_RATIO_GLSL

struct LcRatioTexels {
    vec4 l0;
    vec4 ratio[8];
};
struct LcRatioConstants {
    float range;
    float scale[8];
    float bias[8];
};

LC_FUNCTION LcSh lcLightMapRatio(LcRatioTexels t, LcRatioConstants k) {
    LcSh sh;
    sh.c[0] = k.range * lcRgb(t.l0);
    for (int i = 0; i < 8; ++i) {
        sh.c[i + 1] = sh.c[0] * (k.scale[i] * lcRgb(t.ratio[i]) + lcGrey(k.bias[i]));
    }
    return sh;
}

#endif
