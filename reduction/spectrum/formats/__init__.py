"""Files of spectra that are not text, one file a format: whether it is one, and what it says.

Each has NAME, LIBRARY where one that is installed on request reads it, `begins(raw)`, and `read(raw)`,
which raises Unreadable. They judge nothing: whether an axis is one of wavelengths is not decided here.
"""
