"""New protocols and devices from templates.

Never overwrites a file.
"""
