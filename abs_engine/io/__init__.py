"""Files in and out: arrays, tables, assets and video, each read in one place and written whole."""
