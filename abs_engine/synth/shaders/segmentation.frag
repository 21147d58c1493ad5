#version 330 core

// Facet id + 1 in 24 bits, red the lowest; black for nodes whose `color` is black (the torso).
uniform vec3 color;
out vec4 frag_color;

void main()
{
    int id = color.r > 0.5 ? gl_PrimitiveID + 1 : 0;
    frag_color = vec4(id & 255, (id >> 8) & 255, (id >> 16) & 255, 255) / 255.0;
}
