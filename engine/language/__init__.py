"""The protocol language: YAML with its places, expressions with their types, arguments with units."""
