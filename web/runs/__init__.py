"""Runs as the page sees them: follows journals, talks to engines, starts and resumes runs.

Never writes a journal.
"""
