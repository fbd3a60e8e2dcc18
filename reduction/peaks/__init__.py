"""Background estimation, peak search, and fits of Voigt profiles.

Knows nothing about elements.
"""
