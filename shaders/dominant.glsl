// The dominant light of a place, derived from the light map's coefficients there: no textures of its own.
#ifndef LIGHTCOOK_DOMINANT_GLSL
#define LIGHTCOOK_DOMINANT_GLSL

// Second derivative of the radiance along a and b.
LC_FUNCTION vec3 lcRadianceBent(LcSh sh, vec3 a, vec3 b) {
    return 1.09254843f * ((a.x * b.x - a.y * b.y) * sh.c[8] + (a.x * b.y + a.y * b.x) * sh.c[4] + (a.y * b.z + a.z * b.y) * sh.c[5] +
                          (a.x * b.z + a.z * b.x) * sh.c[7]) +
           (1.89234942f * a.z * b.z) * sh.c[6];
}
// A step of Newton from a unit direction towards the one that maximizes the sum of max(radiance, 0)^2 over the channels.
LC_FUNCTION vec3 lcTowardsLight(LcSh sh, vec3 d) {
    vec3 f = lcRadiance(sh, d);
    vec3 p = max(f, lcGrey(0.0f));
    vec3 lit = vec3(f.x > 0.0f ? 1.0f : 0.0f, f.y > 0.0f ? 1.0f : 0.0f, f.z > 0.0f ? 1.0f : 0.0f);
    vec3 dx = 0.48860251f * sh.c[3] + 1.09254843f * (d.x * sh.c[8] + d.y * sh.c[4] + d.z * sh.c[7]);
    vec3 dy = 0.48860251f * sh.c[1] + 1.09254843f * (d.x * sh.c[4] - d.y * sh.c[8] + d.z * sh.c[5]);
    vec3 dz = 0.48860251f * sh.c[2] + 1.09254843f * (d.y * sh.c[5] + d.x * sh.c[7]) + (1.89234942f * d.z) * sh.c[6];
    vec3 u = normalize(cross(d, abs(d.z) < 0.9f ? vec3(0.0f, 0.0f, 1.0f) : vec3(1.0f, 0.0f, 0.0f)));
    vec3 v = cross(d, u);
    vec3 fu = u.x * dx + u.y * dy + u.z * dz;
    vec3 fv = v.x * dx + v.y * dy + v.z * dz;
    // Gradient and second derivatives on the sphere, halved.
    float outward = dot(d.x * dx + d.y * dy + d.z * dz, p);
    vec2 g = vec2(dot(fu, p), dot(fv, p));
    float uu = dot(lcRadianceBent(sh, u, u), p) + dot(lit * fu, fu) - outward;
    float vv = dot(lcRadianceBent(sh, v, v), p) + dot(lit * fv, fv) - outward;
    float uv = dot(lcRadianceBent(sh, u, v), p) + dot(lit * fu, fv);
    float determinant = uu * vv - uv * uv;
    bool isPeak = uu < 0.0f && determinant > 0.0f;
    // Beside a peak uphill.
    vec2 turn = isPeak ? vec2(uv * g.y - vv * g.x, uv * g.x - uu * g.y) / max(determinant, 1e-30f) : g * (0.3f * inversesqrt(max(dot(g, g), 1e-30f)));
    turn = turn * min(1.0f, 0.4f * inversesqrt(max(dot(turn, turn), 1e-30f)));
    return normalize(d + turn.x * u + turn.y * v);
}
// A directional light: direction unit, intensity that of its delta.
struct LcDominantLight {
    vec3 direction;
    vec3 intensity;
};
// The dominant light of a place from the light map's coefficients there, without textures of its own: the light that is nearest to all of
// them (fit "explained"), dimmed where it explains little. Three channels, three steps; docs/theory/lighting.md, "Derived in the shader".
// normal: stands in for the direction of light that comes from everywhere.
LC_FUNCTION LcDominantLight lcDerivedLight(LcSh sh, vec3 normal) {
    LcDominantLight light;
    float unit = max(max(sh.c[0].x, sh.c[0].y), sh.c[0].z);
    LcSh s;
    float energy = 0.0f;
    for (int i = 0; i < 9; ++i) {
        s.c[i] = sh.c[i] * (unit > 0.0f ? 1.0f / unit : 0.0f);
        energy = energy + dot(s.c[i], s.c[i]);
    }
    light.direction = lcLinearAxis(s, vec3(1.0f, 1.0f, 1.0f));
    if (dot(light.direction, light.direction) < 0.5f) {
        light.direction = normal;
    }
    for (int i = 0; i < 3; ++i) {
        light.direction = lcTowardsLight(s, light.direction);
    }
    // 4 pi / 9 is 1 over the sum of the squared basis functions.
    vec3 p = max(lcRadiance(s, light.direction), lcGrey(0.0f));
    float unexplained = sqrt(max(1.0f - 1.39626340f * dot(p, p) / max(energy, 1e-30f), 0.0f));
    float t = clamp((unexplained - 0.3f) / 0.1f, 0.0f, 1.0f);
    light.intensity = (1.39626340f * max(unit, 0.0f) * (1.0f - t * t * (3.0f - 2.0f * t))) * p;
    return light;
}

#endif
