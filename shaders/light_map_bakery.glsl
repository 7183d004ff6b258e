// Layouts "bakery" and "mono-sh": the SH and MonoSH light maps that Bakery's shaders for Unity read. Texture "l0": L0. Textures "l1x",
// "l1y" and "l1z": t along world axes by colour; or "l1": t along x, y and z as r, g and b, which the colours share:
//   t = L1 / (4 L0) + 1/2,   exit radiance of a white surface = L0 + n . L1 = L0 (1 + 2 sum_i (2 t_i - 1) n_i)
// Nothing is scaled: the engine has no constants. Sources: z3y/ShaderGraph, ShaderLibrary/Bakery.hlsl (SH);
// z3y/ShaderGraph-BuiltIn-Importer, CustomLighting/Bakery.cginc (MonoSH).
#ifndef LIGHTCOOK_LIGHT_MAP_BAKERY_GLSL
#define LIGHTCOOK_LIGHT_MAP_BAKERY_GLSL

struct LcBakeryTexels {
    vec4 l0;
    vec4 l1x;
    vec4 l1y;
    vec4 l1z;
};
struct LcMonoShTexels {
    vec4 l0;
    vec4 l1;
};

// Exit radiance of a white surface, as the engine computes it.
LC_FUNCTION vec3 lcBakeryExitRadiance(LcBakeryTexels t, vec3 n) {
    vec3 along = n.x * (2.0f * lcRgb(t.l1x) - lcGrey(1.0f)) + n.y * (2.0f * lcRgb(t.l1y) - lcGrey(1.0f)) +
                 n.z * (2.0f * lcRgb(t.l1z) - lcGrey(1.0f));
    return lcRgb(t.l0) * (lcGrey(1.0f) + 2.0f * along);
}
LC_FUNCTION vec3 lcMonoShExitRadiance(LcMonoShTexels t, vec3 n) {
    return (1.0f + 2.0f * dot(2.0f * lcRgb(t.l1) - lcGrey(1.0f), n)) * lcRgb(t.l0);
}

// Radiance of bands 0 and 1 that shows the same; band 2 of the result is zero.
LC_FUNCTION LcSh lcLightMapBakery(LcBakeryTexels t) {
    vec3 l0 = lcRgb(t.l0);
    return lcShOfExit(l0, l0 * (4.0f * lcRgb(t.l1y) - lcGrey(2.0f)), l0 * (4.0f * lcRgb(t.l1z) - lcGrey(2.0f)),
                      l0 * (4.0f * lcRgb(t.l1x) - lcGrey(2.0f)));
}
LC_FUNCTION LcSh lcLightMapMonoSh(LcMonoShTexels t) {
    vec3 l0 = lcRgb(t.l0);
    vec3 slope = 4.0f * lcRgb(t.l1) - lcGrey(2.0f);
    return lcShOfExit(l0, slope.y * l0, slope.z * l0, slope.x * l0);
}

#endif
