"""Who may request what: hosts, origins, sessions, control, and commands that run once.

Never carries out a request.
"""
