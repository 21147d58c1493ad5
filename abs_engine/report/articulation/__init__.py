"""The pages and figures of an articulatory model."""
