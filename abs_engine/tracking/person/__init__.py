"""A person: the frames that say who it is, the shape that they share, and its size."""
