"""Data that ships with `reduction`: the table of atomic lines."""
