"""Metrics, tables, pictures, the benchmark."""
