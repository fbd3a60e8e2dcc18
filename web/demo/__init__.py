"""`labrun web --demo`: a simulated bench with its own protocols, and faults on request.

Never reaches a real device.
"""
