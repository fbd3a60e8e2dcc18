"""What spectra say, as tables: peaks, elements, plasma, and what became of each file."""
