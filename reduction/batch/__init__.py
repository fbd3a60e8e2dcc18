"""Batches of spectra: found in folders, reduced by many processes, written as tables.

Never changes a table in place: a folder of tables is replaced as a whole.
"""
