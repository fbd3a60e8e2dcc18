"""Device contracts that ship with labrun, one YAML file each.

Never changed in a way that breaks a driver: a new version gets a new number.
"""
