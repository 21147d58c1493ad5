"""Tracking while a camera films: the newest frame is tracked, late ones are dropped."""
