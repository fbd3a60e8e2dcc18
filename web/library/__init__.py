"""The folder of protocols: files with revisions, and the results of checker and views.

Never overwrites a text that has changed since it was read.
"""
