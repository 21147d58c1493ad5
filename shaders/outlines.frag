// What shows where classes meet: no colours. Depth as in buffers.frag.
in vec2 v_bary;
flat in ivec2 v_ids;
layout(location = 0) out vec4 bary_depth;
layout(location = 1) out ivec2 ids;

void main() {
    bary_depth = vec4(v_bary, 1.0 - v_bary.x - v_bary.y, 1.0 / gl_FragCoord.w);
    ids = v_ids;
}
