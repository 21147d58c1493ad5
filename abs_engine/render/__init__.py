"""Renderers: OpenGL without a screen, and a CPU rasteriser behind the same protocol."""
