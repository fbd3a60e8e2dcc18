"""What the simulated devices obey: time, motion, mass, rock, plasma and light.

Never know what a contract is.
"""
