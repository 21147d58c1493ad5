"""Appearance: colour classes, textures, and the local appearance of points."""
