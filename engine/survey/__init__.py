"""One walk through a protocol: names, scopes, the protocols it uses.

Never judges what it finds: checks do.
"""
