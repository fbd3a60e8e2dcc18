"""A run's report for people and its RO-Crate for machines, made from the run's folder alone.

Never needs a server or a device.
"""
