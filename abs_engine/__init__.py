"""abs_engine: 3D face and lip motion from video, by rendering."""
