"""Lips by learned physics: Basu, Oliver and Pentland (1998), composed."""
