"""Rehearsal: the whole protocol with twins on a virtual clock, hours in seconds.

Never touches a device, a socket or a run's folder.
"""
