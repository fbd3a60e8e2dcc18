"""What drivers of real analysers share: a shot log, export folders, complete spectra.

Never knows how a particular program is operated.
"""
