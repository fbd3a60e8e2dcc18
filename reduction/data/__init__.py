"""Data that ships with `reduction`: the table of atomic lines.

Not edited by hand: `compile_lines.py` makes it.
"""
