"""Figures as a paper prints them, each drawn by a file of its own."""
