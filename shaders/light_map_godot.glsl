// Layout "godot": the light maps that Godot 4.4 and later reads. Texture "sh", four layers: L0, and p along y, z and x, by colour:
//   p = L1 / (8 L0) + 1/2,   exit radiance of a white surface = L0 + n . L1 = L0 (1 + 4 sum_i (2 p_i - 1) n_i)
// Nothing is scaled: the engine has no constants. Source: godotengine/godot, modules/lightmapper_rd/lm_compute.glsl.
#ifndef LIGHTCOOK_LIGHT_MAP_GODOT_GLSL
#define LIGHTCOOK_LIGHT_MAP_GODOT_GLSL

struct LcGodotTexels {
    vec4 sh[4];
};

// Exit radiance of a white surface, as the engine computes it.
LC_FUNCTION vec3 lcGodotExitRadiance(LcGodotTexels t, vec3 n) {
    vec3 along = n.y * (2.0f * lcRgb(t.sh[1]) - lcGrey(1.0f)) + n.z * (2.0f * lcRgb(t.sh[2]) - lcGrey(1.0f)) +
                 n.x * (2.0f * lcRgb(t.sh[3]) - lcGrey(1.0f));
    return lcRgb(t.sh[0]) * (lcGrey(1.0f) + 4.0f * along);
}

// Radiance of bands 0 and 1 that shows the same; band 2 of the result is zero.
LC_FUNCTION LcSh lcLightMapGodot(LcGodotTexels t) {
    vec3 l0 = lcRgb(t.sh[0]);
    return lcShOfExit(l0, l0 * (8.0f * lcRgb(t.sh[1]) - lcGrey(4.0f)), l0 * (8.0f * lcRgb(t.sh[2]) - lcGrey(4.0f)),
                      l0 * (8.0f * lcRgb(t.sh[3]) - lcGrey(4.0f)));
}

#endif
