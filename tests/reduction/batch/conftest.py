from folders import many, shots, spectra, tables_of

__all__ = ["many", "shots", "spectra", "tables_of"]
