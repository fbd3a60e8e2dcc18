"""One family of checks a file; each file's docstring is its page of the manual."""
