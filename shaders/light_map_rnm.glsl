// Layout "rnm": the RNM light maps that Bakery's shaders for Unity read. Textures "rnm0", "rnm1" and "rnm2": light R_i of the three directions
// of Half-Life 2, which are perpendicular to each other. In the tangent frame (x: tangent, y: bitangent, up a picture, z: normal)
//   b_0 = (sqrt(2/3), 0, 1/sqrt(3)),   b_1, b_2 = (-1/sqrt(6), -+1/sqrt(2), 1/sqrt(3))
//   exit radiance of a white surface = sum_i max(0, b_i . n) R_i,   n: normal in the tangent frame, as a normal map has it, green upwards
// Engines whose normal maps are green downwards have y of the basis the other way round. Nothing is scaled: the engine has no constants.
// Source: z3y/ShaderGraph-BuiltIn-Importer, CustomLighting/Bakery.cginc.
#ifndef LIGHTCOOK_LIGHT_MAP_RNM_GLSL
#define LIGHTCOOK_LIGHT_MAP_RNM_GLSL

struct LcRnmTexels {
    vec4 rnm0;
    vec4 rnm1;
    vec4 rnm2;
};

// max(0, b_i . n): how much of each direction a normal of the tangent frame sees.
LC_FUNCTION vec3 lcRnmWeights(vec3 n) {
    float across = 0.57735027f * n.z - 0.40824829f * n.x;
    return vec3(max(0.57735027f * n.z + 0.81649658f * n.x, 0.0f), max(across - 0.70710678f * n.y, 0.0f), max(across + 0.70710678f * n.y, 0.0f));
}

// Exit radiance of a white surface, as the engine computes it. n: unit normal in the tangent frame.
LC_FUNCTION vec3 lcRnmExitRadiance(LcRnmTexels t, vec3 n) {
    vec3 weights = lcRnmWeights(n);
    return weights.x * lcRgb(t.rnm0) + weights.y * lcRgb(t.rnm1) + weights.z * lcRgb(t.rnm2);
}

// Radiance in world axes that shows the same at the surface's own normal, and nearly the same over its hemisphere: no SH of order 2 is that
// function. For shading that takes SH, such as specular light. tangent, bitangent and normal: unit vectors in world axes.
LC_FUNCTION LcSh lcLightMapRnm(LcRnmTexels t, vec3 tangent, vec3 bitangent, vec3 normal) {
    vec3 sum = lcRgb(t.rnm0) + lcRgb(t.rnm1) + lcRgb(t.rnm2);
    vec3 along = lcRgb(t.rnm0) - 0.5f * (lcRgb(t.rnm1) + lcRgb(t.rnm2));
    vec3 across = 0.86602540f * (lcRgb(t.rnm2) - lcRgb(t.rnm1));
    LcSh sh;
    sh.c[0] = 1.22852f * sum;
    sh.c[1] = 1.19369f * across;
    sh.c[2] = 0.30888f * sum;
    sh.c[3] = 1.19369f * along;
    sh.c[4] = -1.14411f * across;
    sh.c[5] = 1.75134f * across;
    sh.c[6] = 0.82550f * sum;
    sh.c[7] = 1.75134f * along;
    sh.c[8] = 1.14411f * along;
    return lcLocalSh(sh, vec3(tangent.x, bitangent.x, normal.x), vec3(tangent.y, bitangent.y, normal.y),
                     vec3(tangent.z, bitangent.z, normal.z));
}

#endif
