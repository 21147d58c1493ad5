"""Colour classes."""
