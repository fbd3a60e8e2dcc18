"""labrun: laboratory experiments as YAML, checked, run on real devices, and never lost."""

__version__ = "0.1.0"
