"""From video to results, frame after frame."""
