"""Problems as people and programs read them, and the manual that explains each code.

Never finds a problem: checks do.
"""
