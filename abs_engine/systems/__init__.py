"""The systems: short compositions of the rooms below."""
