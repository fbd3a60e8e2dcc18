"""A laboratory balance on a serial line, using MT-SICS.

Never reports a weight that the balance does not report as stable, unless asked to.
"""
