"""Everything inside the steps of a drawn protocol, those of used protocols included."""

LISTS = ("steps", "parallel", "any", "then", "else")


def within(other):
    """All steps of a used protocol."""
    return [*other["steps"], *other.get("finally", []), *other.get("on_resume", [])]


def walk(steps):
    """Every step inside these steps."""
    for step in steps:
        yield step
        for key in LISTS:
            yield from walk(step.get(key, []))
        if isinstance(step.get("use"), dict):
            yield from walk(within(step["use"]))
        for watch in step.get("watch", []):
            yield from walk(watch["then"])
        for other in step.get("fallback", []):
            yield from walk(other if isinstance(other, list) else [other])


def acts(steps):
    """The actions among them."""
    return [step for step in walk(steps) if "do" in step]


def devices(steps):
    """The devices that they use, by the names of the protocol that they are in."""
    return frozenset(step["do"].partition(".")[0] for step in acts(steps))


def sets(steps):
    """The devices that they set to something."""
    return devices([step for step in acts(steps) if step["do"].endswith(".set")])
