"""Manual pages for problems found while a file is read; checks have their own.

Contains no code.
"""
