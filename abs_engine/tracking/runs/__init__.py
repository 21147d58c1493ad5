"""Runs as they are written and read: their summary, files and settings."""
