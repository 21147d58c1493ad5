"""Exports: runs in the formats of other programs, each with what it loses."""
