"""Append-only records on disk, each chained to the last by a hash, read back as history.

Never knows what a step is.
"""
