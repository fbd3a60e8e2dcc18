"""The physics of the emission: Saha, Boltzmann, self-absorption, and results for lithium.

Never decides which elements are there.
"""
