"""The paper's own names and types, so that its programs work as they are."""


def add_aliases(site, lab): ...
