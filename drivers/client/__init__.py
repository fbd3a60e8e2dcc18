"""The engine's side of the wire: links, leases, goals, and starting a device server.

Never guesses how a goal ended.
"""
