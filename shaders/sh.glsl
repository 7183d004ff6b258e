// Quadratic spherical harmonics of incident radiance: evaluate, shade, turn into a local frame.
#ifndef LIGHTCOOK_SH_GLSL
#define LIGHTCOOK_SH_GLSL

struct LcSh {
    vec3 c[9];
};
struct LcBasis {
    float y[9];
};

// The nine basis functions at a unit direction.
LC_FUNCTION LcBasis lcBasis(vec3 n) {
    LcBasis b;
    b.y[0] = 0.28209479f;
    b.y[1] = 0.48860251f * n.y;
    b.y[2] = 0.48860251f * n.z;
    b.y[3] = 0.48860251f * n.x;
    b.y[4] = 1.09254843f * n.x * n.y;
    b.y[5] = 1.09254843f * n.y * n.z;
    b.y[6] = 0.31539157f * (3.0f * n.z * n.z - 1.0f);
    b.y[7] = 1.09254843f * n.x * n.z;
    b.y[8] = 0.54627422f * (n.x * n.x - n.y * n.y);
    return b;
}

// sum_l bands_l sum_m c_lm Y_lm(n): what a zonal kernel with these band factors makes of the light.
LC_FUNCTION vec3 lcZonal(LcSh sh, vec3 n, vec3 bands) {
    LcBasis b = lcBasis(n);
    vec3 band1 = b.y[1] * sh.c[1] + b.y[2] * sh.c[2] + b.y[3] * sh.c[3];
    vec3 band2 = b.y[4] * sh.c[4] + b.y[5] * sh.c[5] + b.y[6] * sh.c[6] + b.y[7] * sh.c[7] + b.y[8] * sh.c[8];
    return (bands.x * b.y[0]) * sh.c[0] + bands.y * band1 + bands.z * band2;
}

// Incident radiance from direction n, as the nine coefficients know it.
LC_FUNCTION vec3 lcRadiance(LcSh sh, vec3 n) {
    return lcZonal(sh, n, vec3(1.0f, 1.0f, 1.0f));
}
// Irradiance at normal n.
LC_FUNCTION vec3 lcIrradiance(LcSh sh, vec3 n) {
    return lcZonal(sh, n, vec3(3.14159265f, 2.09439510f, 0.78539816f));
}
// Exit radiance of a white Lambert surface: irradiance over pi. Can be slightly negative (ringing); clamp after adding everything up.
LC_FUNCTION vec3 lcExitRadiance(LcSh sh, vec3 n) {
    return lcZonal(sh, n, vec3(1.0f, 0.66666667f, 0.25f));
}
// The same with the cosine wrapped around by wrap in [0, 1], energy conserving.
LC_FUNCTION vec3 lcExitRadianceWrapped(LcSh sh, vec3 n, float wrap) {
    return lcZonal(sh, n, vec3(1.0f, (2.0f - wrap) / 3.0f, 0.25f * (1.0f - wrap) * (1.0f - wrap)));
}

// Light of bands 0 and 1 under which a white surface shows l0 + x n.x + y n.y + z n.z; band 2 of the result is zero.
LC_FUNCTION LcSh lcShOfExit(vec3 l0, vec3 y, vec3 z, vec3 x) {
    LcSh sh;
    sh.c[0] = 3.54490770f * l0;
    sh.c[1] = 3.06998012f * y;
    sh.c[2] = 3.06998012f * z;
    sh.c[3] = 3.06998012f * x;
    for (int i = 4; i < 9; ++i) {
        sh.c[i] = lcGrey(0.0f);
    }
    return sh;
}

// Subtracts a directional light from the coefficients. towards: unit direction to the light; intensity: of its delta.
LC_FUNCTION LcSh lcWithoutLight(LcSh sh, vec3 towards, vec3 intensity) {
    LcSh r;
    LcBasis b = lcBasis(towards);
    for (int i = 0; i < 9; ++i) {
        r.c[i] = sh.c[i] - b.y[i] * intensity;
    }
    return r;
}

// The axis of band 1 as luminance sees it: a unit vector in any unit of light, no vector (0) where band 1 is 0.
LC_FUNCTION vec3 lcLinearAxis(LcSh sh, vec3 luminance) {
    vec3 v = vec3(dot(luminance, sh.c[3]), dot(luminance, sh.c[1]), dot(luminance, sh.c[2]));
    v = v / max(max(max(abs(v.x), abs(v.y)), abs(v.z)), 1e-30f);
    return v * inversesqrt(max(dot(v, v), 1e-30f));
}

// The coefficients of the same light in a local orthonormal frame: local direction (a, b, c) is the world's a x + b y + c z. Band 1 is a
// vector, band 2 a symmetric matrix without trace: both are turned as such.
LC_FUNCTION LcSh lcLocalSh(LcSh sh, vec3 x, vec3 y, vec3 z) {
    LcSh r;
    r.c[0] = sh.c[0];
    r.c[3] = x.x * sh.c[3] + x.y * sh.c[1] + x.z * sh.c[2];
    r.c[1] = y.x * sh.c[3] + y.y * sh.c[1] + y.z * sh.c[2];
    r.c[2] = z.x * sh.c[3] + z.y * sh.c[1] + z.z * sh.c[2];
    // Band 2 as w' M w in units of 1/2 sqrt(15 / pi); 0.28867513 = 1 / (2 sqrt 3).
    vec3 xx = 0.5f * sh.c[8] - 0.28867513f * sh.c[6];
    vec3 yy = -0.5f * sh.c[8] - 0.28867513f * sh.c[6];
    vec3 zz = 0.57735027f * sh.c[6];
    vec3 xy = 0.5f * sh.c[4];
    vec3 yz = 0.5f * sh.c[5];
    vec3 xz = 0.5f * sh.c[7];
    // Columns of M x, M y, M z.
    vec3 xX = x.x * xx + x.y * xy + x.z * xz;
    vec3 xY = x.x * xy + x.y * yy + x.z * yz;
    vec3 xZ = x.x * xz + x.y * yz + x.z * zz;
    vec3 yX = y.x * xx + y.y * xy + y.z * xz;
    vec3 yY = y.x * xy + y.y * yy + y.z * yz;
    vec3 yZ = y.x * xz + y.y * yz + y.z * zz;
    vec3 zX = z.x * xx + z.y * xy + z.z * xz;
    vec3 zY = z.x * xy + z.y * yy + z.z * yz;
    vec3 zZ = z.x * xz + z.y * yz + z.z * zz;
    r.c[4] = 2.0f * (x.x * yX + x.y * yY + x.z * yZ);
    r.c[5] = 2.0f * (y.x * zX + y.y * zY + y.z * zZ);
    r.c[7] = 2.0f * (x.x * zX + x.y * zY + x.z * zZ);
    r.c[6] = 1.73205081f * (z.x * zX + z.y * zY + z.z * zZ);
    r.c[8] = (x.x * xX + x.y * xY + x.z * xZ) - (y.x * yX + y.y * yY + y.z * yZ);
    return r;
}

#endif
