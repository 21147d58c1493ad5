"""Faces: shapes that move, their regions, and their appearance."""
