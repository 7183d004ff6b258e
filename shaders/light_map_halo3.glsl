// Layout "halo3": textures "luvw_first" and "luvw_second", nine layers each. Coefficient i is a length L and a signed colour uvw:
//   L = range_i a0 a1,   uvw = (2 rgb0 - 1) + (2 rgb1 - 1)
// The second texture is a residual of the first: a1 = a0 leaves L as it is, both hold its square root, and rgb1 = 1/2 leaves uvw.
// After Hu 2008, Lightmap compression in Halo 3.
#ifndef LIGHTCOOK_LIGHT_MAP_HALO3_GLSL
#define LIGHTCOOK_LIGHT_MAP_HALO3_GLSL

struct LcHalo3Texels {
    vec4 first[9];
    vec4 second[9];
};
struct LcHalo3Constants {
    float range[9];
};

LC_FUNCTION LcSh lcLightMapHalo3(LcHalo3Texels t, LcHalo3Constants k) {
    LcSh sh;
    for (int i = 0; i < 9; ++i) {
        vec3 uvw = (2.0f * lcRgb(t.first[i]) - lcGrey(1.0f)) + 2.0f * (lcRgb(t.second[i]) - lcGrey(0.5f));
        sh.c[i] = (k.range[i] * t.first[i].w * t.second[i].w) * uvw;
    }
    return sh;
}

// With the first texture alone, at half the memory and fetches.
LC_FUNCTION LcSh lcLightMapHalo3First(LcHalo3Texels t, LcHalo3Constants k) {
    for (int i = 0; i < 9; ++i) {
        t.second[i] = vec4(0.5f, 0.5f, 0.5f, t.first[i].w);
    }
    return lcLightMapHalo3(t, k);
}

#endif
