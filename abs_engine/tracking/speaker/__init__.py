"""A speaker's own model: it is learned from recordings, and tracked with."""
