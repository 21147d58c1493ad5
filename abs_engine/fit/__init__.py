"""The fit of one frame: what is compared, from where, and what came of it."""
