// Layout "zh3": texture "l0", rgb = coefficient 0 over range; texture "ratio", four layers: layers 0 to 2 coefficients 1 to 3 over
// coefficient 0, layer 3 the zonal coefficient of band 2 over coefficient 0, all mapped to [0, 1]. Band 2 is rotationally symmetric about
// the axis of band 1's luminance, after decoding and filtering: lambda_2m = zonal sqrt(4 pi / 5) Y_2m(axis).
// After Roughton, Sloan, Silvennoinen, Iwanicki and Shirley 2024, ZH3: Quadratic Zonal Harmonics.
#ifndef LIGHTCOOK_LIGHT_MAP_ZH3_GLSL
#define LIGHTCOOK_LIGHT_MAP_ZH3_GLSL

struct LcZh3Texels {
    vec4 l0;
    vec4 ratio[4];
};
struct LcZh3Constants {
    float range;
    float scale[4];
    float bias[4];
    vec3 luminance;  // weights of the working colour space
};

// Returns bands 0 and 1, and in c[4] the zonal coefficient that lcZonalBand2 expands to band 2.
LC_FUNCTION LcSh lcZh3Bands(LcZh3Texels t, LcZh3Constants k) {
    LcSh sh;
    sh.c[0] = k.range * lcRgb(t.l0);
    for (int i = 0; i < 4; ++i) {
        sh.c[i + 1] = sh.c[0] * (k.scale[i] * lcRgb(t.ratio[i]) + lcGrey(k.bias[i]));
    }
    for (int i = 5; i < 9; ++i) {
        sh.c[i] = lcGrey(0.0f);
    }
    return sh;
}

LC_FUNCTION LcSh lcLightMapZh3(LcZh3Texels t, LcZh3Constants k) {
    LcSh bands = lcZh3Bands(t, k);
    return lcZonalBand2(bands, lcLinearAxis(bands, k.luminance));
}

#endif
