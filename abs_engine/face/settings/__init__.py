"""Settings of faces, by stage."""
