"""`labrun web --demo`: a simulated bench with its own protocols, and faults to order."""
