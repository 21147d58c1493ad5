"""Inspection renders: pictures and films of heads, runs and labels, for people to look at."""
