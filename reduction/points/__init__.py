"""What was measured where: rows of a run and the tables of its reduced spectra, joined."""
