"""Somebody's mesh with morph targets made a head that everything here runs on."""
