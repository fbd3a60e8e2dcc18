"""The standard layout of protocol files, as `labrun fmt` writes it.

Never changes what a file means: only blanks and line breaks move.
"""
