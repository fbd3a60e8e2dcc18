"""Simulated devices that keep the same contracts as real ones.

Never need hardware; never reveal the truth that their twins keep over the wire.
"""
