"""Appearance of what is filmed: light and dress, background, lens and sensor."""
