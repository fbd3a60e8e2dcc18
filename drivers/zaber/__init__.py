"""Zaber stages as a gantry, by their maker's library.

Never gives a stage more of its way than a quarter of a second, so that it stops when this program ends.
"""
