"""The systems of the papers: presets, experiments, tables and figures."""
