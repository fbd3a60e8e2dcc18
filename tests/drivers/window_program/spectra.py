"""What the test's analyser program writes: a spectrum of its own for every entry and number."""

import math
import random


def csv_text(entry, number, channels):
    """`wavelength,intensity`, a line with its end for each channel."""
    drawn = random.Random(f"{entry} {number}")
    rows = ["wavelength,intensity"]
    for k in range(channels):
        x = 190 + 760 * k / (channels - 1)
        y = 100 + drawn.random() * 20 + 5000 * math.exp(-(((x - 670.8) / 0.6) ** 2))
        rows.append(f"{x:.4f},{y:.1f}")
    return "\n".join(rows) + "\n"
