"""Requests on their way to devices: queued, journaled, then sent, followed and probed.

Never knows the tree, and never sends what the journal does not hold.
"""
