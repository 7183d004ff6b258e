// Layouts "hdr" and "hdr-2": texture "sh", nine layers. Coefficient 0 is range sh_0; coefficient i is range sh_i + bias_i coefficient 0,
// with bias_i < 0 its least ratio to coefficient 0, so that no texel is negative. Texture "second" of hdr-2 holds
// sh + (exact - sh) / share. Both decodes are linear in the texels, so that filtering does not change them.
// Layout "hdr-rgb9e5" is hdr, with a texture of RGB9E5 where hdr has blocks.
#ifndef LIGHTCOOK_LIGHT_MAP_HDR_GLSL
#define LIGHTCOOK_LIGHT_MAP_HDR_GLSL

struct LcHdrTexels {
    vec4 sh[9];
};
struct LcHdrConstants {
    float range;
    float bias[8];
};

LC_FUNCTION LcSh lcLightMapHdr(LcHdrTexels t, LcHdrConstants k) {
    LcSh sh;
    sh.c[0] = k.range * lcRgb(t.sh[0]);
    for (int i = 1; i < 9; ++i) {
        sh.c[i] = k.range * lcRgb(t.sh[i]) + k.bias[i - 1] * sh.c[0];
    }
    return sh;
}

struct LcHdrRgb9e5Texels {
    vec4 sh[9];
};
struct LcHdrRgb9e5Constants {
    float range;
    float bias[8];
};

LC_FUNCTION LcSh lcLightMapHdrRgb9e5(LcHdrRgb9e5Texels t, LcHdrRgb9e5Constants k) {
    LcHdrTexels texels;
    LcHdrConstants constants;
    constants.range = k.range;
    for (int i = 0; i < 9; ++i) {
        texels.sh[i] = t.sh[i];
    }
    for (int i = 0; i < 8; ++i) {
        constants.bias[i] = k.bias[i];
    }
    return lcLightMapHdr(texels, constants);
}

struct LcHdr2Texels {
    vec4 sh[9];
    vec4 second[9];
};
struct LcHdr2Constants {
    float range;
    float bias[8];
    float share;
};

// The first texture alone: what hdr decodes.
LC_FUNCTION LcSh lcLightMapHdr2First(LcHdr2Texels t, LcHdr2Constants k) {
    LcHdrTexels first;
    for (int i = 0; i < 9; ++i) {
        first.sh[i] = t.sh[i];
    }
    LcHdrConstants constants;
    constants.range = k.range;
    for (int i = 0; i < 8; ++i) {
        constants.bias[i] = k.bias[i];
    }
    return lcLightMapHdr(first, constants);
}

LC_FUNCTION LcSh lcLightMapHdr2(LcHdr2Texels t, LcHdr2Constants k) {
    for (int i = 0; i < 9; ++i) {
        t.sh[i] = mix(t.sh[i], t.second[i], k.share);
    }
    return lcLightMapHdr2First(t, k);
}

#endif
