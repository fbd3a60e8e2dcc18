"""A run's measurements, for the page: tables, maps, spectra, downloads, points to repeat.

Never changes what a run has written.
"""
