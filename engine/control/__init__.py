"""Pause, continue and abort a live run, from signals, other shells and the page.

Never decides what a run does next: it only asks for it.
"""
