"""The models of everything that crosses a boundary: YAML, socket, disk, browser.

Never import anything else of labrun.
"""
