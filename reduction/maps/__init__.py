"""Values at points laid out on a plane, scaled and sorted into classes.

Draws nothing.
"""
