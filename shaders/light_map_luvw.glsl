// Layout "luvw": textures "luvw_first" and "luvw_second", nine layers each. Coefficient i is a length L and a signed colour uvw:
//   L = range_i a0 a1,   uvw = (2 rgb0 - 1) + 2 span_i (rgb1 - centre)
// The second texture is a residual of the first. It is zero at rgb1 = centre, and at a1 = neutral (root = 0: a0 holds L) or a1 = neutral a0
// (root = 1: a0 and a1 hold its square root, which maps of great range need).
// Layout "luvw-linear" has five layers each: coefficients 0 to 3, and the intensity I of a light from the axis of band 1's luminance,
// decoded and filtered. Band 2 is that light's: lambda_i = I Y_i(axis). After the form that Halo 3 shipped.
// After Hu 2008, Lightmap compression in Halo 3.
// Layouts "halo3" and "halo3-linear" are these two with that engine's own constants: span = 1, centre = 1/2, neutral = 1, root = 1:
//   L = range_i a0 a1,   uvw = (2 rgb0 - 1) + (2 rgb1 - 1)
#ifndef LIGHTCOOK_LIGHT_MAP_LUVW_GLSL
#define LIGHTCOOK_LIGHT_MAP_LUVW_GLSL

struct LcLuvwTexels {
    vec4 first[9];
    vec4 second[9];
};
struct LcLuvwConstants {
    float range[9];
    float span[9];
    vec4 neutral;  // rgb: centre, a: neutral
    float root;    // 0 or 1
};

LC_FUNCTION vec3 lcLuvw(vec4 first, vec4 second, float range, float span, vec3 centre) {
    vec3 uvw = (2.0f * lcRgb(first) - lcGrey(1.0f)) + (2.0f * span) * (lcRgb(second) - centre);
    return (range * first.w * second.w) * uvw;
}

LC_FUNCTION LcSh lcLightMapLuvw(LcLuvwTexels t, LcLuvwConstants k) {
    LcSh sh;
    for (int i = 0; i < 9; ++i) {
        sh.c[i] = lcLuvw(t.first[i], t.second[i], k.range[i], k.span[i], lcRgb(k.neutral));
    }
    return sh;
}

// With the first texture alone, at half the memory and fetches.
LC_FUNCTION LcSh lcLightMapLuvwFirst(LcLuvwTexels t, LcLuvwConstants k) {
    LcSh sh;
    for (int i = 0; i < 9; ++i) {
        vec3 centre = lcRgb(k.neutral);
        float a1 = k.neutral.w * mix(1.0f, t.first[i].w, k.root);
        sh.c[i] = lcLuvw(t.first[i], vec4(centre.x, centre.y, centre.z, a1), k.range[i], k.span[i], centre);
    }
    return sh;
}

struct LcLuvwLinearTexels {
    vec4 first[5];
    vec4 second[5];
};
struct LcLuvwLinearConstants {
    float range[5];
    float span[5];
    vec4 neutral;
    float root;
    vec3 luminance;  // weights of the working colour space
};

// Returns bands 0 and 1, and in c[4] the zonal coefficient that lcZonalBand2 expands to band 2.
LC_FUNCTION LcSh lcLuvwLinearBands(LcLuvwLinearTexels t, LcLuvwLinearConstants k) {
    LcSh sh;
    for (int i = 0; i < 5; ++i) {
        sh.c[i] = lcLuvw(t.first[i], t.second[i], k.range[i], k.span[i], lcRgb(k.neutral));
    }
    // sqrt(5 / 4 pi): the length of Y_2(axis).
    sh.c[4] = 0.63078313f * sh.c[4];
    for (int i = 5; i < 9; ++i) {
        sh.c[i] = lcGrey(0.0f);
    }
    return sh;
}

LC_FUNCTION LcSh lcLightMapLuvwLinear(LcLuvwLinearTexels t, LcLuvwLinearConstants k) {
    LcSh bands = lcLuvwLinearBands(t, k);
    return lcZonalBand2(bands, lcLinearAxis(bands, k.luminance));
}

// With the first texture alone, at half the memory and fetches.
LC_FUNCTION LcSh lcLightMapLuvwLinearFirst(LcLuvwLinearTexels t, LcLuvwLinearConstants k) {
    for (int i = 0; i < 5; ++i) {
        t.second[i] = vec4(k.neutral.x, k.neutral.y, k.neutral.z, k.neutral.w * mix(1.0f, t.first[i].w, k.root));
    }
    return lcLightMapLuvwLinear(t, k);
}

struct LcHalo3Texels {
    vec4 first[9];
    vec4 second[9];
};
struct LcHalo3Constants {
    float range[9];
};
struct LcHalo3LinearTexels {
    vec4 first[5];
    vec4 second[5];
};
struct LcHalo3LinearConstants {
    float range[5];
    vec3 luminance;  // weights of the working colour space
};

LC_FUNCTION vec3 lcHalo3(vec4 first, vec4 second, float range) {
    return lcLuvw(first, second, range, 1.0f, lcGrey(0.5f));
}

LC_FUNCTION LcSh lcLightMapHalo3(LcHalo3Texels t, LcHalo3Constants k) {
    LcSh sh;
    for (int i = 0; i < 9; ++i) {
        sh.c[i] = lcHalo3(t.first[i], t.second[i], k.range[i]);
    }
    return sh;
}

// With the first texture alone, at half the memory and fetches: a1 = a0, as both hold the square root of L.
LC_FUNCTION LcSh lcLightMapHalo3First(LcHalo3Texels t, LcHalo3Constants k) {
    for (int i = 0; i < 9; ++i) {
        t.second[i] = vec4(0.5f, 0.5f, 0.5f, t.first[i].w);
    }
    return lcLightMapHalo3(t, k);
}

LC_FUNCTION LcSh lcHalo3LinearBands(LcHalo3LinearTexels t, LcHalo3LinearConstants k) {
    LcSh sh;
    for (int i = 0; i < 5; ++i) {
        sh.c[i] = lcHalo3(t.first[i], t.second[i], k.range[i]);
    }
    sh.c[4] = 0.63078313f * sh.c[4];
    for (int i = 5; i < 9; ++i) {
        sh.c[i] = lcGrey(0.0f);
    }
    return sh;
}

LC_FUNCTION LcSh lcLightMapHalo3Linear(LcHalo3LinearTexels t, LcHalo3LinearConstants k) {
    LcSh bands = lcHalo3LinearBands(t, k);
    return lcZonalBand2(bands, lcLinearAxis(bands, k.luminance));
}

LC_FUNCTION LcSh lcLightMapHalo3LinearFirst(LcHalo3LinearTexels t, LcHalo3LinearConstants k) {
    for (int i = 0; i < 5; ++i) {
        t.second[i] = vec4(0.5f, 0.5f, 0.5f, t.first[i].w);
    }
    return lcLightMapHalo3Linear(t, k);
}

#endif
