"""From a folder of reduced spectra to maps, classes, tables and figures.

Never reads a spectrum's channels.
"""
