// Clip coordinates come ready; label and texture coordinates pass through. Thin path: attribute
// `clip`, one candidate. LAYERED: the coordinates that deform.comp wrote, one instance a candidate.
#ifdef LAYERED
#extension GL_ARB_shader_viewport_layer_array : require
layout(std430, binding = 0) readonly buffer Clip { vec4 clips[]; };
uniform int n_vertices;
in int source;
#else
in vec4 clip;
#endif
#ifdef TERM_CLASS
in int label;
flat out int v_label;
#else
in vec2 uv;
out vec2 v_uv;
#endif

void main() {
#ifdef LAYERED
    gl_Position = clips[gl_InstanceID * n_vertices + source];
    gl_Layer = gl_InstanceID;
#else
    gl_Position = clip;
#endif
#ifdef TERM_CLASS
    v_label = label;  // the facet's last vertex, which provokes, carries its label
#else
    v_uv = uv;
#endif
}
