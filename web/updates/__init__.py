"""Push from the server to browsers, over Socket.IO.

Never waits for a slow browser.
"""
