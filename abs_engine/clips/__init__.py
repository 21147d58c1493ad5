"""Many clips at once: each tracked as alone, by workers of a Dask scheduler."""
