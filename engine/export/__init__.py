"""A run as a file of another program's format, one format a file.

Never changes the run's folder.
"""
