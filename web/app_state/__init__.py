"""Everything that one `labrun web` has, assembled at start and closed in order.

Never handles a request.
"""
