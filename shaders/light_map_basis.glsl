// Layouts "basis-3", "basis-4", "basis-8", "basis-12", "basis-16", "basis-20", "basis-24": texture "l0", rgb = coefficient 0 over range;
// texture "code", three or four numbers c; texture "residual" (basis-8 and up), four more numbers in each layer. Coefficients 1 to 8 over
// coefficient 0 are a quadratic polynomial of c, whose factors were learned from the map for each cluster of charts; each layer of the
// residual adds a linear basis, to coefficient 0 too:
//   lambda_i = l0 (P_i(c) + sum_k (r_k - neutral) R_ki),   P_0 = 1
// A shader short of fetches may stop after the code, or after any layer of the residual.
// Filter "decoded": lambda is linear in l0 times the monomials of c, and in l0 times the residual. lcMixBasis3, lcMixBasis4 and
// lcMixBasisAdd sum these over the four texels around a place, which have one cluster, and read each factor once.
// The factors are half floats in texture "tables", RGBA16F: a row for each cluster; in it first v of LcBasisFirst, then v of the
// LcBasisResidual of each layer, a texel for each. The functions whose names end in From fetch them; or copy them into buffers.
// The cluster is the chart's, the same wherever a filter reaches: the cooked mesh's vertex attribute _LIGHTCOOK_BASIS, handed on flat, or
// lcBasisCluster of texture "index", fetched without filtering. The manifest has one of the two. The index has one byte for each block of
// 4 x 4 texels, four neighbours of a row in a texel.
#ifndef LIGHTCOOK_LIGHT_MAP_BASIS_GLSL
#define LIGHTCOOK_LIGHT_MAP_BASIS_GLSL

// One cluster's factors. Monomial j of coefficient i + 1 is v[8 j + i]; monomials in the order of lcBasisMonomials.
struct LcBasisFirst3 {
    vec3 v[80];
};
struct LcBasisFirst4 {
    vec3 v[120];
};
// Channel k of coefficient i is v[9 k + i].
struct LcBasisResidual {
    vec3 v[36];
};
struct LcBasisMonomials {
    float m[15];
};

// Block of 4 x 4 texels that a place of the light map lies in. mapSize: of the light map [texels].
LC_FUNCTION vec2 lcBasisBlock(vec2 uv, vec2 mapSize) {
    vec2 texel = clamp(floor(uv * mapSize), vec2(0.0f, 0.0f), mapSize - vec2(1.0f, 1.0f));
    return floor(texel * 0.25f);
}
// Texture coordinate of the index.
LC_FUNCTION vec2 lcBasisIndexUv(vec2 uv, vec2 mapSize) {
    vec2 block = lcBasisBlock(uv, mapSize);
    vec2 size = floor(vec2(mapSize.x + 15.0f, mapSize.y + 3.0f) * vec2(0.0625f, 0.25f));
    return vec2(floor(block.x * 0.25f) + 0.5f, block.y + 0.5f) / size;
}
// Cluster from a texel of the index.
LC_FUNCTION int lcBasisCluster(vec4 indexTexel, vec2 uv, vec2 mapSize) {
    float column = lcBasisBlock(uv, mapSize).x;
    float which = column - 4.0f * floor(column * 0.25f);
    float stored = which < 1.5f ? (which < 0.5f ? indexTexel.x : indexTexel.y) : (which < 2.5f ? indexTexel.z : indexTexel.w);
    return int(stored * 255.0f + 0.5f);
}

// 1, a b c, squares and products of the three; then all that holds the fourth.
LC_FUNCTION LcBasisMonomials lcBasisMonomials(vec4 c) {
    LcBasisMonomials r;
    r.m[0] = 1.0f;
    r.m[1] = c.x;
    r.m[2] = c.y;
    r.m[3] = c.z;
    r.m[4] = c.x * c.x;
    r.m[5] = c.x * c.y;
    r.m[6] = c.x * c.z;
    r.m[7] = c.y * c.y;
    r.m[8] = c.y * c.z;
    r.m[9] = c.z * c.z;
    r.m[10] = c.w;
    r.m[11] = c.x * c.w;
    r.m[12] = c.y * c.w;
    r.m[13] = c.z * c.w;
    r.m[14] = c.w * c.w;
    return r;
}

LC_FUNCTION LcSh lcLightMapBasis3(vec4 l0, vec4 code, LcBasisFirst3 basis, float range) {
    LcBasisMonomials m = lcBasisMonomials(code);
    LcSh sh;
    sh.c[0] = range * lcRgb(l0);
    for (int i = 0; i < 8; ++i) {
        vec3 sum = basis.v[i];
        for (int j = 1; j < 10; ++j) {
            sum = sum + m.m[j] * basis.v[8 * j + i];
        }
        sh.c[i + 1] = sh.c[0] * sum;
    }
    return sh;
}

LC_FUNCTION LcSh lcLightMapBasis4(vec4 l0, vec4 code, LcBasisFirst4 basis, float range) {
    LcBasisMonomials m = lcBasisMonomials(code);
    LcSh sh;
    sh.c[0] = range * lcRgb(l0);
    for (int i = 0; i < 8; ++i) {
        vec3 sum = basis.v[i];
        for (int j = 1; j < 15; ++j) {
            sum = sum + m.m[j] * basis.v[8 * j + i];
        }
        sh.c[i + 1] = sh.c[0] * sum;
    }
    return sh;
}

// What one layer of the residual adds to sh. neutral: the code that adds nothing.
LC_FUNCTION LcSh lcLightMapBasisAdd(LcSh sh, vec4 l0, vec4 residual, LcBasisResidual basis, float range, float neutral) {
    vec3 dc = range * lcRgb(l0);
    float x = residual.x - neutral;
    float y = residual.y - neutral;
    float z = residual.z - neutral;
    float w = residual.w - neutral;
    LcSh r;
    for (int i = 0; i < 9; ++i) {
        r.c[i] = sh.c[i] + dc * (x * basis.v[i] + y * basis.v[9 + i] + z * basis.v[18 + i] + w * basis.v[27 + i]);
    }
    return r;
}

// Range, weights and l0 of the texels around a place, multiplied: the order of LcQuad.
struct LcBasisQuad {
    vec3 light00;
    vec3 light10;
    vec3 light01;
    vec3 light11;
};
LC_FUNCTION LcBasisQuad lcBasisQuad(vec4 l00, vec4 l10, vec4 l01, vec4 l11, vec4 weights, float range) {
    vec4 w = range * weights;
    LcBasisQuad q;
    q.light00 = w.x * lcRgb(l00);
    q.light10 = w.y * lcRgb(l10);
    q.light01 = w.z * lcRgb(l01);
    q.light11 = w.w * lcRgb(l11);
    return q;
}

// Monomials of the codes, and numbers of a residual layer, times the light of their texels, summed.
struct LcBasisSums {
    vec3 m[15];
};
struct LcBasisResidualSums {
    vec3 x;
    vec3 y;
    vec3 z;
    vec3 w;
};
LC_FUNCTION LcBasisSums lcBasisSums(LcBasisQuad q, vec4 c00, vec4 c10, vec4 c01, vec4 c11) {
    LcBasisMonomials m00 = lcBasisMonomials(c00);
    LcBasisMonomials m10 = lcBasisMonomials(c10);
    LcBasisMonomials m01 = lcBasisMonomials(c01);
    LcBasisMonomials m11 = lcBasisMonomials(c11);
    LcBasisSums sums;
    for (int j = 0; j < 15; ++j) {
        sums.m[j] = m00.m[j] * q.light00 + m10.m[j] * q.light10 + m01.m[j] * q.light01 + m11.m[j] * q.light11;
    }
    return sums;
}
LC_FUNCTION LcBasisResidualSums lcBasisResidualSums(LcBasisQuad q, vec4 r00, vec4 r10, vec4 r01, vec4 r11, float neutral) {
    vec4 n = vec4(neutral, neutral, neutral, neutral);
    vec4 a = r00 - n;
    vec4 b = r10 - n;
    vec4 c = r01 - n;
    vec4 d = r11 - n;
    LcBasisResidualSums sums;
    sums.x = a.x * q.light00 + b.x * q.light10 + c.x * q.light01 + d.x * q.light11;
    sums.y = a.y * q.light00 + b.y * q.light10 + c.y * q.light01 + d.y * q.light11;
    sums.z = a.z * q.light00 + b.z * q.light10 + c.z * q.light01 + d.z * q.light11;
    sums.w = a.w * q.light00 + b.w * q.light10 + c.w * q.light01 + d.w * q.light11;
    return sums;
}

// The light of four texels, mixed. c00 to c11: their codes; r00 to r11: what they have in one layer of the residual.
LC_FUNCTION LcSh lcMixBasis3(LcBasisQuad q, vec4 c00, vec4 c10, vec4 c01, vec4 c11, LcBasisFirst3 basis) {
    LcBasisSums sums = lcBasisSums(q, c00, c10, c01, c11);
    LcSh sh;
    sh.c[0] = sums.m[0];
    for (int i = 0; i < 8; ++i) {
        vec3 sum = sums.m[0] * basis.v[i];
        for (int j = 1; j < 10; ++j) {
            sum = sum + sums.m[j] * basis.v[8 * j + i];
        }
        sh.c[i + 1] = sum;
    }
    return sh;
}
LC_FUNCTION LcSh lcMixBasis4(LcBasisQuad q, vec4 c00, vec4 c10, vec4 c01, vec4 c11, LcBasisFirst4 basis) {
    LcBasisSums sums = lcBasisSums(q, c00, c10, c01, c11);
    LcSh sh;
    sh.c[0] = sums.m[0];
    for (int i = 0; i < 8; ++i) {
        vec3 sum = sums.m[0] * basis.v[i];
        for (int j = 1; j < 15; ++j) {
            sum = sum + sums.m[j] * basis.v[8 * j + i];
        }
        sh.c[i + 1] = sum;
    }
    return sh;
}
LC_FUNCTION LcSh lcMixBasisAdd(LcSh sh, LcBasisQuad q, vec4 r00, vec4 r10, vec4 r01, vec4 r11, LcBasisResidual basis, float neutral) {
    LcBasisResidualSums sums = lcBasisResidualSums(q, r00, r10, r01, r11, neutral);
    LcSh r;
    for (int i = 0; i < 9; ++i) {
        r.c[i] = sh.c[i] + sums.x * basis.v[i] + sums.y * basis.v[9 + i] + sums.z * basis.v[18 + i] + sums.w * basis.v[27 + i];
    }
    return r;
}

// The same decodes with the factors from texture "tables".
LC_FUNCTION LcSh lcBasisFrom(vec4 l0, LcBasisMonomials m, int monomialCount, LC_TABLES tables, int cluster, float range) {
    LcSh sh;
    sh.c[0] = range * lcRgb(l0);
    for (int i = 0; i < 8; ++i) {
        vec3 sum = lcRgb(lcTableTexel(tables, i, cluster));
        for (int j = 1; j < monomialCount; ++j) {
            sum = sum + m.m[j] * lcRgb(lcTableTexel(tables, 8 * j + i, cluster));
        }
        sh.c[i + 1] = sh.c[0] * sum;
    }
    return sh;
}

LC_FUNCTION LcSh lcLightMapBasis3From(vec4 l0, vec4 code, LC_TABLES tables, int cluster, float range) {
    return lcBasisFrom(l0, lcBasisMonomials(code), 10, tables, cluster, range);
}

LC_FUNCTION LcSh lcLightMapBasis4From(vec4 l0, vec4 code, LC_TABLES tables, int cluster, float range) {
    return lcBasisFrom(l0, lcBasisMonomials(code), 15, tables, cluster, range);
}

// layer: of the residual, from 0; layouts with a residual have four numbers in "code".
LC_FUNCTION LcSh lcLightMapBasisAddFrom(LcSh sh, vec4 l0, vec4 residual, LC_TABLES tables, int cluster, int layer, float range, float neutral) {
    int at = 120 + 36 * layer;
    vec3 dc = range * lcRgb(l0);
    float x = residual.x - neutral;
    float y = residual.y - neutral;
    float z = residual.z - neutral;
    float w = residual.w - neutral;
    LcSh r;
    for (int i = 0; i < 9; ++i) {
        vec3 a = lcRgb(lcTableTexel(tables, at + i, cluster));
        vec3 b = lcRgb(lcTableTexel(tables, at + 9 + i, cluster));
        vec3 c = lcRgb(lcTableTexel(tables, at + 18 + i, cluster));
        vec3 d = lcRgb(lcTableTexel(tables, at + 27 + i, cluster));
        r.c[i] = sh.c[i] + dc * (x * a + y * b + z * c + w * d);
    }
    return r;
}

LC_FUNCTION LcSh lcMixBasisFrom(LcBasisSums sums, int monomialCount, LC_TABLES tables, int cluster) {
    LcSh sh;
    sh.c[0] = sums.m[0];
    for (int i = 0; i < 8; ++i) {
        vec3 sum = sums.m[0] * lcRgb(lcTableTexel(tables, i, cluster));
        for (int j = 1; j < monomialCount; ++j) {
            sum = sum + sums.m[j] * lcRgb(lcTableTexel(tables, 8 * j + i, cluster));
        }
        sh.c[i + 1] = sum;
    }
    return sh;
}

LC_FUNCTION LcSh lcMixBasis3From(LcBasisQuad q, vec4 c00, vec4 c10, vec4 c01, vec4 c11, LC_TABLES tables, int cluster) {
    return lcMixBasisFrom(lcBasisSums(q, c00, c10, c01, c11), 10, tables, cluster);
}

LC_FUNCTION LcSh lcMixBasis4From(LcBasisQuad q, vec4 c00, vec4 c10, vec4 c01, vec4 c11, LC_TABLES tables, int cluster) {
    return lcMixBasisFrom(lcBasisSums(q, c00, c10, c01, c11), 15, tables, cluster);
}

LC_FUNCTION LcSh lcMixBasisAddFrom(LcSh sh, LcBasisQuad q, vec4 r00, vec4 r10, vec4 r01, vec4 r11, LC_TABLES tables, int cluster, int layer,
                                   float neutral) {
    LcBasisResidualSums sums = lcBasisResidualSums(q, r00, r10, r01, r11, neutral);
    int at = 120 + 36 * layer;
    LcSh r;
    for (int i = 0; i < 9; ++i) {
        r.c[i] = sh.c[i] + sums.x * lcRgb(lcTableTexel(tables, at + i, cluster)) + sums.y * lcRgb(lcTableTexel(tables, at + 9 + i, cluster)) +
                 sums.z * lcRgb(lcTableTexel(tables, at + 18 + i, cluster)) + sums.w * lcRgb(lcTableTexel(tables, at + 27 + i, cluster));
    }
    return r;
}

#endif
