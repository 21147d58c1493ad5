"""The clip's own texture: how a head that shows it has moved between two frames."""
