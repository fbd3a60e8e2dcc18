"""Messages to people: sending them, and a device that does.

Never knows of runs: who is told of what happens in one is the engine's.
"""
