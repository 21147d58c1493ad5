// The pixel terms of scene.py, summed over the drawn pixels: one work group for each layer.
layout(local_size_x = 256) in;
struct Sum { float total; uint pixels; };
layout(std430, binding = 0) writeonly buffer Sums { Sum sums[]; };
uniform ivec2 size;
shared float totals[256];
shared uint counts[256];

#ifdef TERM_CLASS
uniform isampler2DArray drawn;
uniform sampler2DArray maps;

bool pixel_term(ivec3 at, out float term) {
    int facet_class = texelFetch(drawn, at, 0).r;
    term = texelFetch(maps, ivec3(at.xy, facet_class), 0).r;
    return facet_class > 0;
}
#else
#include "texture.glsl"
uniform sampler2DArray drawn;
uniform sampler2D target;  // the frame, luminance-normalised

bool pixel_term(ivec3 at, out float term) {
    vec2 uv = texelFetch(drawn, at, 0).rg;
    vec3 c = texture_colour(uv, at.z) + 1.0;
    vec3 d = c / (c.r + c.g + c.b) - texelFetch(target, at.xy, 0).rgb;
    term = dot(d, d);
    return uv.x > -1e29;  // the background is cleared to -1e30
}
#endif

void main() {
    int layer = int(gl_WorkGroupID.x);
    uint lane = gl_LocalInvocationID.x;
    float total = 0.0;
    uint pixels = 0u;
    for (int i = int(lane); i < size.x * size.y; i += 256) {
        float term;
        if (pixel_term(ivec3(i % size.x, i / size.x, layer), term)) {
            total += term;
            ++pixels;
        }
    }
    totals[lane] = total;
    counts[lane] = pixels;
    for (uint half_size = 128u; half_size > 0u; half_size >>= 1) {
        barrier();
        if (lane < half_size) {
            totals[lane] += totals[lane + half_size];
            counts[lane] += counts[lane + half_size];
        }
    }
    if (lane == 0u) sums[layer] = Sum(totals[0], counts[0]);
}
