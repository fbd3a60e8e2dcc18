"""What was measured where: rows of a run joined with the tables of its reduced spectra.

Never reduces anything.
"""
