"""A protocol compiled into a behaviour tree, and the loop that ticks it.

Never touches a socket or a disk.
"""
