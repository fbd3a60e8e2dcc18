"""The points of a protocol over the work area, before anything moves.

Never asks a device where it is.
"""
