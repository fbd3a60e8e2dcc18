"""Data that ships with `reduction`: the table of atomic lines.

Not edited by hand: `lines/compile_lines.py` makes it.
"""
