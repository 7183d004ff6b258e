// Layouts "basis-3", "basis-4", "basis-8", "basis-12", "basis-16", "basis-20", "basis-24": texture "l0", rgb = coefficient 0 over range;
// texture "code", three or four numbers c; texture "residual" (basis-8 and up), four more numbers in each layer. Coefficients 1 to 8 over
// coefficient 0 are a quadratic polynomial of c, whose factors were learned from the map for each cluster of charts; each layer of the
// residual adds a linear basis, to coefficient 0 too:
//   lambda_i = l0 (P_i(c) + sum_k (r_k - neutral) R_ki),   P_0 = 1
// A shader short of fetches may stop after the code, or after any layer of the residual.
// The factors are half floats in texture "tables", RGBA16F: a row for each cluster; in it first v of LcBasisFirst, then v of the
// LcBasisResidual of each layer, a texel for each. Fetch them with lcLightMapBasis3From, lcLightMapBasis4From and lcLightMapBasisAddFrom,
// or copy them into buffers.
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

#endif
