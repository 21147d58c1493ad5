"""Authored speech and the studio that films it."""
