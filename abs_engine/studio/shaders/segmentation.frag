#version 330 core

// Facet id + 1 in red (low byte) and green of a node whose `color` has red; of any other node, a
// prop, its code in blue. See worker.py.
uniform vec3 color;
out vec4 frag_color;

void main()
{
    int id = color.r > 0.5 ? gl_PrimitiveID + 1 : 0;
    int code = color.r > 0.5 ? 0 : int(color.b * 255.0 + 0.5);
    frag_color = vec4(id & 255, (id >> 8) & 255, code, 255) / 255.0;
}
