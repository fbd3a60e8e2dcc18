"""JSON Schemas (2020-12) made from the models beside it; `python -m labrun.schemas.generate`."""
