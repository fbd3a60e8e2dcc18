"""Optimizers as devices: told what was measured, they suggest what to try next.

Never keep anything in memory alone: what they suggest follows from what is on disk.
"""
