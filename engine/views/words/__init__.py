"""A protocol in plain English, for the lab book.

Never evaluates what only a run can know.
"""
