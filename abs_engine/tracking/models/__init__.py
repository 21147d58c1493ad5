"""Models that a clip can be tracked with, prepared for it."""
