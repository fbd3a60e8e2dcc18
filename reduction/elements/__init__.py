"""Identify elements: match candidate lines with peaks, and weigh the evidence.

Never fits a peak.
"""
