"""What the command `articulate` writes of an articulatory model."""
