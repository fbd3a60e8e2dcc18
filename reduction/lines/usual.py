"""The usual lines for LIBS of rocks."""

USUAL_LINES = {
    "H": (1, 656.28),
    "Li": (1, 670.78),
    "Be": (2, 313.04),
    "C": (1, 247.856),
    "N": (1, 746.831),
    "O": (1, 777.194),
    "Na": (1, 588.995),
    "Mg": (2, 279.553),
    "Al": (1, 396.152),
    "Si": (1, 288.158),
    "K": (1, 766.490),
    "Ca": (2, 393.366),
    "Ti": (2, 334.941),
    "Mn": (2, 257.610),
    "Fe": (1, 371.993),
    "Rb": (1, 780.027),
    "Sr": (2, 407.771),
    "Cs": (1, 852.113),
    "Ba": (2, 455.403),
}
"""Stage and wavelength in air (nm): strong, little overlapped in silicates, and within reach of the usual
detectors; other elements take their strongest line."""
