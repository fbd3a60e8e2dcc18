"""Torture: real runs of a protocol, killed and cut off in every way, held against the promise."""
