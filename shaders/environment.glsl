// Environment reflections: a prefiltered cubemap divided by the area specular at its own place, times the area specular of the pixel. The
// map brings the detail, the light map the energy. Or a prefiltered cubemap as it is, which brings both.
#ifndef LIGHTCOOK_ENVIRONMENT_GLSL
#define LIGHTCOOK_ENVIRONMENT_GLSL

// Mirror direction of the view (unit, away from the surface).
LC_FUNCTION vec3 lcReflection(vec3 view, vec3 normal) {
    return 2.0f * dot(view, normal) * normal - view;
}

// Area specular of SH light around a direction by a zonal kernel (bands: what the mip was filtered and divided with), never negative.
LC_FUNCTION vec3 lcZonalSpecular(LcSh sh, vec3 reflection, vec3 bands) {
    return max(lcZonal(sh, reflection, bands), lcGrey(0.0f));
}

// stored: filtered texel of the pre-divided cubemap; S: area specular of the pixel (lcZonalSpecular or lcAreaSpecular).
LC_FUNCTION vec3 lcEnvironment(vec3 stored, vec3 S) {
    return stored * S;
}

// stored: filtered texel of a prefiltered cubemap that is not divided; range: of its constants. Radiance through the lobe of the mip.
LC_FUNCTION vec3 lcPrefiltered(vec3 stored, float range) {
    return range * stored;
}

#endif
