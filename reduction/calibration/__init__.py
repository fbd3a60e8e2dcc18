"""Concentrations from areas: standards, curves, and what a calibration says of a spectrum.

Never finds or fits a line itself: it asks the reduction.
"""
