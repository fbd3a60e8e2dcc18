"""The results of spectra as tables: peaks, elements, plasma, and the outcome of each file.

They compute nothing: they lay out results.
"""
