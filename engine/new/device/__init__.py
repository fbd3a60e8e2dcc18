"""A new device: contract, driver, simulated twin and their contract test, ready to be changed.

Does not need the instrument.
"""
