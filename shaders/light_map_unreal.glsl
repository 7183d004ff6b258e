// Layout "unreal-hq": the high-quality light maps that Unreal's shaders read, as two textures of four channels:
//   lightmap0  rgb: roots of the colour; a: the logarithm of the luminance
//   lightmap1  rgb: one direction for all colours, along y, z and x; a: 255 times what rounding took from the logarithm
// Constants scale0, add0, scale1 and add1 are the engine's LightMapScale and LightMapAdd:
//   LogL = (a0 + (a1 - 1/2) / 255) scale0.a + add0.a    L = 2^LogL - 0.01858136    UVW = rgb0^2 scale0.rgb + add0.rgb
//   SH = lightmap1 scale1 + add1                        scale1.a is 0, add1.a the first basis function
//   exit radiance of a white surface = L UVW max(0, SH.rgb . n.yzx + SH.a)
// Everything comes after the filter. Source: Unreal, Engine/Shaders/Private/LightmapCommon.ush.
#ifndef LIGHTCOOK_LIGHT_MAP_UNREAL_GLSL
#define LIGHTCOOK_LIGHT_MAP_UNREAL_GLSL

struct LcUnrealHqTexels {
    vec4 lightmap0;
    vec4 lightmap1;
};
struct LcUnrealHqConstants {
    vec4 scale0;
    vec4 add0;
    vec4 scale1;
    vec4 add1;
};

// L UVW: the light of a surface whose directionality is 1.
LC_FUNCTION vec3 lcUnrealHqLight(LcUnrealHqTexels t, LcUnrealHqConstants k) {
    float logL = (t.lightmap0.w + (t.lightmap1.w - 0.5f) * 0.00392156863f) * k.scale0.w + k.add0.w;
    vec3 root = lcRgb(t.lightmap0);
    return (exp2(logL) - 0.01858136f) * (root * root * lcRgb(k.scale0) + lcRgb(k.add0));
}

// Exit radiance of a white surface, as the engine computes it.
LC_FUNCTION vec3 lcUnrealHqExitRadiance(LcUnrealHqTexels t, LcUnrealHqConstants k, vec3 n) {
    vec4 sh = t.lightmap1 * k.scale1 + k.add1;
    return max(0.0f, sh.x * n.y + sh.y * n.z + sh.z * n.x + sh.w) * lcUnrealHqLight(t, k);
}

// Radiance of bands 0 and 1 that shows the same where the directionality is not negative; band 2 of the result is zero.
LC_FUNCTION LcSh lcLightMapUnrealHq(LcUnrealHqTexels t, LcUnrealHqConstants k) {
    vec3 light = lcUnrealHqLight(t, k);
    vec4 sh = t.lightmap1 * k.scale1 + k.add1;
    return lcShOfExit(sh.w * light, sh.x * light, sh.y * light, sh.z * light);
}

#endif
