"""Faces in a picture and their landmarks, by networks that OpenCV runs."""
