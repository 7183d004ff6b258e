// Layouts "lit", "lit-half", "lit-quarter": the light of a texel is one directional light and the rest. Texture "l0", rgb = coefficient 0
// over range; "light", rgb = intensity of that light over range; "direction", xy = its direction by octahedral projection, mapped to [0, 1];
// "rest", eight layers, rgb of layer i - 1 = coefficient i of the rest over its coefficient 0, mapped to [0, 1]:
//   rest_0 = lambda_0 - I Y_0,   lambda_i = rest_0 ratio_i + I Y_i(d)
// A texel of "rest" is that of 1 x 1, 2 x 2 or 4 x 4 texels of the map. Filter: decoded (filter.glsl).
// The light may be dimmed, tinted or switched off: lcLightMapLitDimmed.
#ifndef LIGHTCOOK_LIGHT_MAP_LIT_GLSL
#define LIGHTCOOK_LIGHT_MAP_LIT_GLSL

struct LcLitTexels {
    vec4 l0;
    vec4 light;
    vec4 direction;
    vec4 rest[8];
};
struct LcLitConstants {
    float range;
    float scale[8];
    float bias[8];
};

// Unit direction towards the light.
LC_FUNCTION vec3 lcLitDirection(vec4 direction) {
    vec2 p = vec2(2.0f * direction.x - 1.0f, 2.0f * direction.y - 1.0f);
    vec3 d = vec3(p.x, p.y, 1.0f - abs(p.x) - abs(p.y));
    float below = max(-d.z, 0.0f);
    d.x = d.x - (d.x >= 0.0f ? below : -below);
    d.y = d.y - (d.y >= 0.0f ? below : -below);
    return d * inversesqrt(dot(d, d));
}
// Intensity of the light.
LC_FUNCTION vec3 lcLitIntensity(vec4 light, LcLitConstants k) {
    return k.range * lcRgb(light);
}

// The texel's light, with that of the one light times dim: (1, 1, 1) as baked, (0, 0, 0) switched off.
LC_FUNCTION LcSh lcLightMapLitDimmed(LcLitTexels t, LcLitConstants k, vec3 dim) {
    LcBasis b = lcBasis(lcLitDirection(t.direction));
    vec3 intensity = lcLitIntensity(t.light, k);
    vec3 rest = max(k.range * lcRgb(t.l0) - b.y[0] * intensity, lcGrey(0.0f));
    intensity = dim * intensity;
    LcSh sh;
    sh.c[0] = rest + b.y[0] * intensity;
    for (int i = 0; i < 8; ++i) {
        sh.c[i + 1] = rest * (k.scale[i] * lcRgb(t.rest[i]) + lcGrey(k.bias[i])) + b.y[i + 1] * intensity;
    }
    return sh;
}

LC_FUNCTION LcSh lcLightMapLit(LcLitTexels t, LcLitConstants k) {
    return lcLightMapLitDimmed(t, k, lcGrey(1.0f));
}

#endif
