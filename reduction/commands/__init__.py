"""Commands of the reduction: registered as `labrun.commands`, one function per file.

They compute nothing: they read options and report.
"""
