"""Runs as the page sees them: journals followed, engines spoken to, runs started and resumed."""
