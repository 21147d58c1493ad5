// Colour only, for inspection pictures.
#include "texture.glsl"
in vec2 v_uv;
flat in int v_layer;
layout(location = 0) out vec4 colour;

void main() {
    colour = vec4(texture_colour(v_uv, v_layer) / 255.0, 1.0);
}
