"""What drivers of real analysers share: a book of shots, export folders, spectra that are whole."""
