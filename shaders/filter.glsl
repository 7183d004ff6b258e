// Filter "decoded": the four texels around a place are fetched, each is decoded, and their light is mixed with weights that are floats of
// the shader. Texels outside charts have no weight, so that charts need no padding.
//   LcQuad q = lcQuad(uv, mapSize);
//   q = lcCoveredQuad(q, coverage of q.texel00, of texel10, of texel01, of texel11);
//   LcSh sh = lcMix(decode of q.texel00, of texel10, of texel01, of texel11, q.weights);
// With a temporal filter one texel may stand for the four: lcQuadTexel.
// A map with detail has some texels in layout "lit": lcHasDetail.
#ifndef LIGHTCOOK_FILTER_GLSL
#define LIGHTCOOK_FILTER_GLSL

// Texels around a place, in whole numbers from 0, and their weights in the order 00, 10, 01, 11, whose sum is 1.
struct LcQuad {
    vec2 texel00;
    vec2 texel10;
    vec2 texel01;
    vec2 texel11;
    vec4 weights;
};

// mapSize: of the light map [texels].
LC_FUNCTION LcQuad lcQuad(vec2 uv, vec2 mapSize) {
    vec2 place = uv * mapSize - vec2(0.5f, 0.5f);
    vec2 low = floor(place);
    vec2 f = place - low;
    vec2 last = mapSize - vec2(1.0f, 1.0f);
    vec2 first = clamp(low, vec2(0.0f, 0.0f), last);
    vec2 second = clamp(low + vec2(1.0f, 1.0f), vec2(0.0f, 0.0f), last);
    LcQuad q;
    q.texel00 = first;
    q.texel10 = vec2(second.x, first.y);
    q.texel01 = vec2(first.x, second.y);
    q.texel11 = second;
    q.weights = vec4((1.0f - f.x) * (1.0f - f.y), f.x * (1.0f - f.y), (1.0f - f.x) * f.y, f.x * f.y);
    return q;
}

// Texel of texture "coverage" that has the bit of a texel of the map.
LC_FUNCTION vec2 lcCoverageTexel(vec2 texel) {
    return floor(texel * vec2(0.125f, 0.25f));
}
// 1 for a texel inside a chart, else 0. coverageTexel: RGBA8, channel i has row i of 8 x 4 texels, its lowest bit the first column.
LC_FUNCTION float lcCovered(vec4 coverageTexel, vec2 texel) {
    float row = texel.y - 4.0f * floor(texel.y * 0.25f);
    float column = texel.x - 8.0f * floor(texel.x * 0.125f);
    float stored = row < 1.5f ? (row < 0.5f ? coverageTexel.x : coverageTexel.y) : (row < 2.5f ? coverageTexel.z : coverageTexel.w);
    float bits = floor(stored * 255.0f + 0.5f);
    for (int i = 0; i < 7; ++i) {
        if (float(i) < column) {
            bits = floor(bits * 0.5f);
        }
    }
    return bits - 2.0f * floor(bits * 0.5f);
}

// The quad with the weights of its covered texels alone; of one without any, as it is. covered: of texels 00, 10, 01, 11.
LC_FUNCTION LcQuad lcCoveredQuad(LcQuad q, vec4 covered) {
    vec4 weights = q.weights * covered;
    float sum = weights.x + weights.y + weights.z + weights.w;
    if (sum > 0.0f) {
        q.weights = weights / sum;
    }
    return q;
}

// One of the four texels, each as often as it weighs. random: in [0, 1).
LC_FUNCTION vec2 lcQuadTexel(LcQuad q, float random) {
    vec2 texel = q.texel11;
    texel = random < q.weights.x + q.weights.y + q.weights.z ? q.texel01 : texel;
    texel = random < q.weights.x + q.weights.y ? q.texel10 : texel;
    return random < q.weights.x ? q.texel00 : texel;
}

// True where the tile of a texel has detail: then the texel is that of lcDetailTexel, in the textures "detail_hdr" and "detail_ldr" of
// layout "lit". tile: texel lcCoverageTexel of the second layer of texture "coverage".
LC_FUNCTION bool lcHasDetail(vec4 tile) {
    return tile.w > 0.5f;
}
// x of the tile is its column there, y and z its row: the low and the high byte.
LC_FUNCTION vec2 lcDetailTexel(vec4 tile, vec2 texel) {
    vec2 place = vec2(floor(tile.x * 255.0f + 0.5f), floor(tile.y * 255.0f + 0.5f) + 256.0f * floor(tile.z * 255.0f + 0.5f));
    return vec2(8.0f, 4.0f) * (place - lcCoverageTexel(texel)) + texel;
}

LC_FUNCTION LcSh lcMix(LcSh a, LcSh b, LcSh c, LcSh d, vec4 weights) {
    LcSh r;
    for (int i = 0; i < 9; ++i) {
        r.c[i] = weights.x * a.c[i] + weights.y * b.c[i] + weights.z * c.c[i] + weights.w * d.c[i];
    }
    return r;
}

#endif
