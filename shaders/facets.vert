// Every facet has three vertices of its own, fetched by index, so that ids and barycentrics need
// neither a provoking vertex nor gl_PrimitiveID.
#ifdef LAYERED
#extension GL_ARB_shader_viewport_layer_array : require
#endif
layout(std430, binding = 0) readonly buffer Clip { vec4 clips[]; };
layout(std430, binding = 1) readonly buffer Faces { int faces[]; };
layout(std430, binding = 2) readonly buffer Uv { vec2 uvs[]; };
layout(std430, binding = 3) readonly buffer Classes { int facet_class[]; };
#ifdef KEPT
layout(std430, binding = 5) readonly buffer Kept { int kept[]; };  // facets that are drawn
#endif
uniform int n_vertices;
out vec2 v_uv;
out vec2 v_bary;
flat out ivec2 v_ids;
flat out int v_layer;

void main() {
#ifdef KEPT
    int facet = kept[gl_VertexID / 3];
#else
    int facet = gl_VertexID / 3;
#endif
    int corner = gl_VertexID % 3;
    int vertex = faces[3 * facet + corner];
    gl_Position = clips[gl_InstanceID * n_vertices + vertex];
#ifdef LAYERED
    gl_Layer = gl_InstanceID;
#endif
    v_layer = gl_InstanceID;
    v_uv = uvs[vertex];
    v_bary = vec2(corner == 0, corner == 1);
    v_ids = ivec2(facet + 1, facet_class[facet]);
}
