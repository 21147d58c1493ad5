"""A clip's start: its head is placed, its mouth fitted and its colours learned."""
