"""JSON Schemas (2020-12) made from the models in `schemas` by `python -m labrun.schemas.generate`.

Never edited by hand.
"""
