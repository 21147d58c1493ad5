"""Faces that can be drawn, of points that were measured on a speaker."""
