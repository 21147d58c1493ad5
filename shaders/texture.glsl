// Bilinear texture colour, 0 to 255, clamped to the edge; pixel = uv * size - 0.5, v down.
// By hand and not by the sampler: hardware filters weigh with 8 bits, which would part the
// renderers from each other.
// TEXTURE_MODES: the colour depends on the weights of the candidate in `layer`.
uniform sampler2D skin;

#ifdef TEXTURE_MODES
uniform sampler2DArray skin_modes;
uniform int n_texture_modes;
layout(std430, binding = 4) readonly buffer TextureWeights { float texture_weights[]; };

vec3 mode_texel(ivec2 at, int layer) {
    vec3 sum = vec3(0.0);
    for (int p = 0; p < n_texture_modes; ++p) {
        float weight = texture_weights[layer * n_texture_modes + p];
        sum += weight * texelFetch(skin_modes, ivec3(at, p), 0).rgb;
    }
    return 255.0 * texelFetch(skin, at, 0).rgb + sum;
}
#else
vec3 mode_texel(ivec2 at, int layer) {
    return 255.0 * texelFetch(skin, at, 0).rgb;
}
#endif

vec3 texture_colour(vec2 uv, int layer) {
    ivec2 last = textureSize(skin, 0) - 1;
    vec2 p = clamp(uv * vec2(last + 1) - 0.5, vec2(0.0), vec2(last));
    ivec2 a = ivec2(p);
    ivec2 b = min(a + 1, last);
    vec2 f = p - vec2(a);
    vec3 top = mix(mode_texel(a, layer), mode_texel(ivec2(b.x, a.y), layer), f.x);
    vec3 low = mix(mode_texel(ivec2(a.x, b.y), layer), mode_texel(b, layer), f.x);
    return clamp(mix(top, low, f.y), 0.0, 255.0);
}
