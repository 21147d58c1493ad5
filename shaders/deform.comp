// X = mean + weights . modes, pose, lens distortion (Camera.distort), clip matrix: one invocation
// for each vertex (x) of each candidate (y), so every vertex is deformed once however many facets
// share it.
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Clip { vec4 clips[]; };
layout(std430, binding = 1) readonly buffer Mean { float mean[]; };
layout(std430, binding = 2) readonly buffer Modes { float modes[]; };
layout(std430, binding = 3) readonly buffer States { float states[]; };  // R|t rows, then weights
uniform int n_vertices;
uniform int n_modes;
uniform mat4 clip_matrix;
uniform float k[8];
uniform float radius_limit;  // 0: no distortion

vec3 distort(vec3 p) {
    float z = abs(p.z) < 1e-9 ? 1e-9 : p.z;
    vec2 q = p.xy / z;
    float rr = dot(q, q);
    vec2 tangential = vec2(2.0 * k[2] * q.x * q.y + k[3] * (rr + 2.0 * q.x * q.x),
                           k[2] * (rr + 2.0 * q.y * q.y) + 2.0 * k[3] * q.x * q.y);
    if (rr > radius_limit) tangential = vec2(0.0);
    rr = min(rr, radius_limit);
    float radial = (1.0 + rr * (k[0] + rr * (k[1] + rr * k[4])))
                 / (1.0 + rr * (k[5] + rr * (k[6] + rr * k[7])));
    return vec3((q * radial + tangential) * p.z, p.z);
}

void main() {
    int vertex = int(gl_GlobalInvocationID.x);
    if (vertex >= n_vertices) return;
    int candidate = int(gl_GlobalInvocationID.y);
    int state = candidate * (12 + n_modes);
    vec3 x = vec3(mean[3 * vertex], mean[3 * vertex + 1], mean[3 * vertex + 2]);
    for (int p = 0; p < n_modes; ++p) {
        int at = 3 * (p * n_vertices + vertex);
        x += states[state + 12 + p] * vec3(modes[at], modes[at + 1], modes[at + 2]);
    }
    vec3 cam;
    for (int row = 0; row < 3; ++row) {
        int at = state + 4 * row;
        cam[row] = dot(vec3(states[at], states[at + 1], states[at + 2]), x) + states[at + 3];
    }
    if (radius_limit > 0.0) cam = distort(cam);
    clips[candidate * n_vertices + vertex] = clip_matrix * vec4(cam, 1.0);
}
