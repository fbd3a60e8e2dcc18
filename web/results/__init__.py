"""What a run has measured, for the page: tables, maps, spectra, downloads, points to measure again."""
