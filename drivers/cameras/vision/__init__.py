"""Where a camera is, how far away things are, and where on the bench a pixel points.

Never talks to a camera: it works on pictures.
"""
