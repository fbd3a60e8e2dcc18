"""The table of atomic lines, and wavelengths in air and in vacuum.

Knows nothing about spectra.
"""
