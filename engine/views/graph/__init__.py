"""The tree of a protocol as a picture's text: Mermaid or DOT."""
