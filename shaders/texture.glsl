// Bilinear texture colour, 0 to 255, clamped to the edge; pixel = uv * size - 0.5, v down.
// By hand and not by the sampler: hardware filters weigh with 8 bits, which would part the
// renderers from each other.
uniform sampler2D skin;


vec3 texture_colour(vec2 uv) {
    ivec2 last = textureSize(skin, 0) - 1;
    vec2 p = clamp(uv * vec2(last + 1) - 0.5, vec2(0.0), vec2(last));
    ivec2 a = ivec2(p);
    ivec2 b = min(a + 1, last);
    vec2 f = p - vec2(a);
    vec3 top = mix(texelFetch(skin, a, 0).rgb, texelFetch(skin, ivec2(b.x, a.y), 0).rgb, f.x);
    vec3 low = mix(texelFetch(skin, ivec2(a.x, b.y), 0).rgb, texelFetch(skin, b, 0).rgb, f.x);
    return 255.0 * mix(top, low, f.y);
}
