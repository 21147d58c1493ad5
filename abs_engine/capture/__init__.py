"""From cameras to points in space: calibration, dots followed in two views, the head frame.

After section 3 of Basu, Oliver and Pentland, "3D Modeling and Tracking of Human Lip Motions",
1998.
"""
