"""Many spectra: found in folders, reduced by many processes, written as tables."""
