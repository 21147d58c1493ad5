"""What can move, and what it looks like: shapes, regions and appearance."""
