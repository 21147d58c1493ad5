// What a pixel shows: its label, of a class or a facet, or its texture coordinates.
#ifdef TERM_CLASS
flat in int v_label;
layout(location = 0) out int value;

void main() {
    value = v_label;
}
#else
in vec2 v_uv;
layout(location = 0) out vec2 value;

void main() {
    value = v_uv;
}
#endif
