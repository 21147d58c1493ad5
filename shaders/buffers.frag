// All buffers of buffers.py. Depth is 1 / gl_FragCoord.w: clip w is z of the camera frame.
#include "texture.glsl"
in vec2 v_uv;
flat in int v_layer;
in vec2 v_bary;
flat in ivec2 v_ids;
layout(location = 0) out vec4 colour_depth;
layout(location = 1) out vec2 barycentrics;
layout(location = 2) out ivec2 ids;

void main() {
    colour_depth = vec4(texture_colour(v_uv, v_layer), 1.0 / gl_FragCoord.w);
    barycentrics = v_bary;
    ids = v_ids;
}
