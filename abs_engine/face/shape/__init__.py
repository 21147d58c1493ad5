"""Linear shape models."""
