"""A gantry behind Klipper, by Moonraker's WebSocket.

Never gives Klipper more of a move than it can end within: Klipper knows no feed hold.
"""
