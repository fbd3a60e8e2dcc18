"""Drivers through which a whole library or language of instruments is reached.

Most need no code for an instrument: its lab entry says what each action sends. A bridge imports
its library only when used.
"""
