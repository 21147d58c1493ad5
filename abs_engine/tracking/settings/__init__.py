"""Settings of the tracker, by stage."""
