"""The nodes of a run's tree, one kind per file.

Never wait: a node is ticked, reports its status, and returns.
"""
