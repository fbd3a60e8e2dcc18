"""Deterministic simulation: engines, device servers, wire, disks and time in one process, by a seed.

Never touches a device or a socket, and changes nothing in the code that it runs but its surroundings.
"""
