"""Figures for print, each in a separate file.

They compute nothing that they show.
"""
