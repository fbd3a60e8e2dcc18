"""A protocol as people want to see it before a run: explained, counted, in words, drawn.

Never needs a device.
"""
