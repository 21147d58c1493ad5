"""Results of frames: what is measured of them, kept of them, warned of and drawn."""
