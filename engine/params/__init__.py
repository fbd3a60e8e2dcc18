"""The parameters that a protocol declares, and the values given to them.

Never evaluates a step.
"""
