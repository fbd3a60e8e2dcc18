"""Spectra: reading files, marking bad channels, estimating noise.

Never looks for peaks.
"""
