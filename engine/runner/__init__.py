"""The course of a run: start, connect, phases, safe state, reports.

Never decides what a step does: the tree does.
"""
