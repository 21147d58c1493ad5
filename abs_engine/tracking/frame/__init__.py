"""A frame that is followed: its pose, whether its mouth is seen, the problem that is solved."""
