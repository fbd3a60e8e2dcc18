"""Real runs of a protocol, killed and cut off in every way, then compared with the promise.

Never changes the engine that it kills, and never trusts its journal alone.
"""
