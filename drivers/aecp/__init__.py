"""The driver for the paper's own analyser server.

Never needs a change to that server.
"""
