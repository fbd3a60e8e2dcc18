"""One family of checks a file; each file's docstring is its page in the manual.

Never sends anything to a device, and never raises: a check yields problems.
"""
