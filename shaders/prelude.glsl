// lightcook.glsl: decode and shade what lightcook cooked. One source for GLSL 4.50, GLSL ES 3.00, HLSL (define LIGHTCOOK_HLSL first) and
// C++.
//
// No samplers here: the engine fetches (filtered, trilinear or bilinear), these functions decode and shade what it fetched.
// SH is real, orthonormal, without Condon-Shortley signs, coefficient (l, m) at l (l + 1) + m. Light is incident radiance; what a surface
// shows is exit radiance: the division by pi of a Lambert surface is inside, multiply by the albedo.
#ifndef LIGHTCOOK_GLSL
#define LIGHTCOOK_GLSL

#ifdef LIGHTCOOK_HLSL
#define vec2 float2
#define vec3 float3
#define vec4 float4
#define mix lerp
#define fract frac
#define inversesqrt rsqrt
#endif
#ifdef GL_ES
precision highp float;
#endif
#ifndef LC_FUNCTION
#define LC_FUNCTION
#endif
// The texture with the tables of a learned layout: its type as a parameter, and one texel of it, not filtered.
#ifndef LC_TABLES
#ifdef LIGHTCOOK_HLSL
#define LC_TABLES Texture2D<float4>
#define lcTableTexel(tables, column, row) tables.Load(int3(column, row, 0))
#else
#define LC_TABLES highp sampler2D
#define lcTableTexel(tables, column, row) texelFetch(tables, ivec2(column, row), 0)
#endif
#endif

LC_FUNCTION vec3 lcRgb(vec4 texel) {
    return vec3(texel.x, texel.y, texel.z);
}
LC_FUNCTION vec3 lcGrey(float value) {
    return vec3(value, value, value);
}

#endif
