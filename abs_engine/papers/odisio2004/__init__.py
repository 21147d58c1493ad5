"""Odisio and Bailly (2003): talking faces by seven articulatory parameters."""
