"""The driver of an analyser's desktop program: shots, and spectra that are proved to be theirs.

Never clicks by itself: the window, its buttons and its dialogs are `window_program`'s.
"""
