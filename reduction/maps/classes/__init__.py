"""Points of a map sorted into classes, and the mineral that each class may be.

Never claims a mineral: it suggests.
"""
