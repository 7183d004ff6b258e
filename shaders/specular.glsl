// Specular light: area specular of SH light from the C and D tables, and Cook-Torrance for a punctual or dominant light.
// After Chen and Liu 2008, Lighting and Material of Halo 3, with two misprints corrected: Schlick is (1 - L.H)^5, and the
// energy-conserving form divides D by pi and the product by 4 NoL NoV.
#ifndef LIGHTCOOK_SPECULAR_GLSL
#define LIGHTCOOK_SPECULAR_GLSL

// One fetch of the three table textures, filtered, for one roughness and view angle: C and D for coefficients 0, 2, 3, 6 and 7, 8 (the
// others vanish by symmetry). As fetched: unorm; after lcSpecularKernel: values.
struct LcSpecularKernel {
    vec4 c0236;
    vec4 d0236;
    vec4 cd78;
};
// value = scale * unorm + bias, per texture and channel.
struct LcSpecularConstants {
    LcSpecularKernel scale;
    LcSpecularKernel bias;
};
LC_FUNCTION LcSpecularKernel lcSpecularKernel(LcSpecularKernel texels, LcSpecularConstants k) {
    LcSpecularKernel r;
    r.c0236 = k.scale.c0236 * texels.c0236 + k.bias.c0236;
    r.d0236 = k.scale.d0236 * texels.d0236 + k.bias.d0236;
    r.cd78 = k.scale.cd78 * texels.cd78 + k.bias.cd78;
    return r;
}

// Returns the coordinate in which a table's axis is uniform, for t = NoV or t = m: sqrt((p0 + p1 t) (q0 + q1 t)). factors: the axis's
// (p0, p1, q0, q1), from the manifest. The result is t itself for (0, 1, 0, 1), which an engine that knows its tables need not compute, and
// the sine of the view's angle for (1, -1, 1, 1) and t = NoV.
LC_FUNCTION float lcTableAxis(float t, vec4 factors) {
    return sqrt(max((factors.x + factors.y * t) * (factors.z + factors.w * t), 0.0f));
}
// Texture coordinate on a table axis. value: result of lcTableAxis; scale and offset are the axis's.
LC_FUNCTION float lcTableCoordinate(float value, float scale, float offset) {
    return clamp(value * scale + offset, 0.0f, 1.0f);
}
// sin(theta_v) of a view, for tables whose x axis it is.
LC_FUNCTION float lcSine(float NoV) {
    return sqrt(clamp(1.0f - NoV * NoV, 0.0f, 1.0f));
}

// The frame in which the kernel is defined: z the normal, view in the x-z plane, x towards the view. view and normal are unit vectors, view
// points away from the surface.
struct LcFrame {
    vec3 x;
    vec3 y;
    vec3 z;
};
LC_FUNCTION LcFrame lcViewFrame(vec3 normal, vec3 view) {
    LcFrame f;
    f.z = normal;
    vec3 tangent = view - dot(view, normal) * normal;
    float squared = dot(tangent, tangent);
    if (squared > 1e-8f) {
        f.x = tangent * inversesqrt(squared);
    } else {
        // Looking along the normal: every azimuth sees the same lobe.
        vec3 other = abs(normal.z) < 0.9f ? vec3(0.0f, 0.0f, 1.0f) : vec3(1.0f, 0.0f, 0.0f);
        f.x = normalize(other - dot(other, normal) * normal);
    }
    f.y = cross(f.z, f.x);
    return f;
}

// Reflected radiance of SH light: sum_i c_i (f0 C_i + (1 - f0) D_i). local: lcLocalSh in the frame of lcViewFrame.
LC_FUNCTION vec3 lcAreaSpecular(LcSh local, LcSpecularKernel kernel, vec3 f0) {
    vec3 c = kernel.c0236.x * local.c[0] + kernel.c0236.y * local.c[2] + kernel.c0236.z * local.c[3] + kernel.c0236.w * local.c[6] +
             kernel.cd78.x * local.c[7] + kernel.cd78.y * local.c[8];
    vec3 d = kernel.d0236.x * local.c[0] + kernel.d0236.y * local.c[2] + kernel.d0236.z * local.c[3] + kernel.d0236.w * local.c[6] +
             kernel.cd78.z * local.c[7] + kernel.cd78.w * local.c[8];
    return f0 * c + (lcGrey(1.0f) - f0) * d;
}

// Schlick's Fresnel term. The clamp keeps rounding in LoH from feeding pow a negative base.
LC_FUNCTION vec3 lcSchlick(vec3 f0, float LoH) {
    float u = clamp(1.0f - LoH, 0.0f, 1.0f);
    float u2 = u * u;
    return f0 + (lcGrey(1.0f) - f0) * (u2 * u2 * u);
}

// Fresnel by the index of refraction that f0 stands for, unpolarised (Cook and Torrance 1982). The guards keep f0 = 0 and f0 = 1, and the
// root at grazing angles, finite.
LC_FUNCTION float lcFresnelExact(float f0, float LoH) {
    float root = sqrt(clamp(f0, 0.0f, 0.9999f));
    float eta = (1.0f + root) / (1.0f - root);
    float c = clamp(LoH, 0.0f, 1.0f);
    float g = sqrt(max(eta * eta + c * c - 1.0f, 0.0f));
    float a = (g - c) / max(g + c, 1e-6f);
    float b = (c * (g + c) - 1.0f) / (c * (g - c) + 1.0f);
    return clamp(0.5f * a * a * (1.0f + b * b), 0.0f, 1.0f);
}

// Beckmann's distribution, integral of D cos over the hemisphere 1.
LC_FUNCTION float lcBeckmann(float NoH, float m) {
    float c2 = max(NoH * NoH, 1e-6f);
    float m2 = max(m * m, 1e-6f);
    return exp((c2 - 1.0f) / (c2 * m2)) / (3.14159265f * m2 * c2 * c2);
}

// GGX (Trowbridge and Reitz), integral of D cos over the hemisphere 1. m is alpha: the square of glTF's roughness, as for Beckmann.
LC_FUNCTION float lcGgx(float NoH, float m) {
    float c2 = NoH * NoH;
    float m2 = max(m * m, 1e-6f);
    float d = (1.0f - c2) + m2 * c2;
    return m2 / (3.14159265f * d * d);
}

// The distribution of the scene: cubemaps and tables were made with it. An include of a scene with lobe = "ggx" begins with
// #define LIGHTCOOK_GGX.
LC_FUNCTION float lcDistribution(float NoH, float m) {
#ifdef LIGHTCOOK_GGX
    return lcGgx(NoH, m);
#else
    return lcBeckmann(NoH, m);
#endif
}

// F D G / (4 NoL NoV), energy conserving [1/sr], with the geometry term of Cook and Torrance: V-shaped cavities, which are consistent with
// any distribution (Heitz 2014). All directions unit, away from the surface. Zero below the horizon.
LC_FUNCTION vec3 lcCookTorrance(vec3 view, vec3 light, vec3 normal, float m, vec3 f0) {
    float NoV = dot(normal, view);
    float NoL = dot(normal, light);
    if (NoV <= 0.0f || NoL <= 0.0f) {
        return lcGrey(0.0f);
    }
    vec3 halfway = normalize(view + light);
    float NoH = clamp(dot(normal, halfway), 0.0f, 1.0f);
    float VoH = max(dot(view, halfway), 1e-6f);
    float g = min(1.0f, 2.0f * NoH * min(NoV, NoL) / VoH);
    return (lcDistribution(NoH, m) * g / (4.0f * NoV * NoL)) * lcSchlick(f0, VoH);
}
// The same as Halo 3's listing scales it: four times as bright.
LC_FUNCTION vec3 lcCookTorranceHalo3(vec3 view, vec3 light, vec3 normal, float m, vec3 f0) {
    return 4.0f * lcCookTorrance(view, light, normal, m, f0);
}

// The direction as two textures hold it, the second a residual of the first. lcDominantDirection takes scale * this + bias. Both filter
// linearly. Without the second texture (a distant surface, a weaker platform) the first one alone is the direction, coarser.
LC_FUNCTION vec3 lcDominantStored(vec3 first, vec3 residual, float residualScale, float residualCentre) {
    return first + residualScale * (residual - lcGrey(residualCentre));
}
// The unit direction to the dominant light. fetched: unnormalised; where its length is close to 0, the direction is noise, and the normal
// stands in for it.
LC_FUNCTION vec3 lcDominantDirection(vec3 fetched, vec3 normal) {
    float squared = dot(fetched, fetched);
    return squared > 1e-8f ? fetched * inversesqrt(squared) : normal;
}
// Reflected radiance of the dominant light. fetchedDirection: unnormalised; its length is its weight under the filter. intensity:
// radiometric, of the delta that the fit found.
LC_FUNCTION vec3 lcDominantSpecular(vec3 view, vec3 fetchedDirection, vec3 intensity, vec3 normal, float m, vec3 f0) {
    vec3 light = lcDominantDirection(fetchedDirection, normal);
    return max(dot(normal, light), 0.0f) * intensity * lcCookTorrance(view, light, normal, m, f0);
}

// Specular light of light map and dominant light together: the highlight of the dominant light, and area specular of the SH light without
// it, so that none counts twice. sh: the light map's, world frame; direction and intensity as fetched; kernel: lcSpecularKernel for m and
// NoV. Best with the fit "explained", whose intensity is low where no direction dominates.
LC_FUNCTION vec3 lcWholeSpecular(vec3 view, LcSh sh, vec3 fetchedDirection, vec3 intensity, vec3 normal, float m, vec3 f0,
                                 LcSpecularKernel kernel) {
    LcFrame frame = lcViewFrame(normal, view);
    LcSh rest = lcWithoutLight(sh, lcDominantDirection(fetchedDirection, normal), intensity);
    return lcDominantSpecular(view, fetchedDirection, intensity, normal, m, f0) +
           lcAreaSpecular(lcLocalSh(rest, frame.x, frame.y, frame.z), kernel, f0);
}

#endif
