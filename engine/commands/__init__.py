"""The commands of `labrun`, one per file.

Never holds logic that a route of the page needs too.
"""
