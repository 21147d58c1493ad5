"""Comparison of buffers and fused sums with the frame."""
