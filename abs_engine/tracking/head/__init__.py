"""The pose of a whole head, and its shape in several frames, by landmarks, texture and outline."""
