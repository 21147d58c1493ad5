"""Landmarks as evidence: their places on a head, their noise, and the fit of a frame to them."""
