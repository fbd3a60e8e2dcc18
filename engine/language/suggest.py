"""Guess what was meant by a mistyped name."""

from collections.abc import Iterable

MEANT = {
    "action": "do", "call": "do",
    "args": "with", "arguments": "with", "parameters": "with", "params": "with",
    "body": "steps", "tasks": "steps", "block": "steps",
    "catch": "fallback", "except": "fallback", "rescue": "fallback",
    "always": "finally", "ensure": "finally",
    "condition": "when", "unless": "when", "choose": "if", "switch": "if",
    "count": "attempts repeat", "times": "attempts repeat", "tries": "attempts",
    "delay": "wait", "sleep": "wait", "backoff": "factor",
    "elif": "else if", "elseif": "else if", "otherwise": "else",
    "for": "foreach", "loop": "foreach", "until": "while",
    "inputs": "params", "returns": "outputs",
    "vars": "set params", "variables": "set params", "env": "set params", "output": "outputs id",
    "print": "log", "echo": "log", "message": "log",
    "ignore": "continue", "skip": "continue", "abort": "stop", "fail": "stop", "raise": "stop",
    "as": "id", "register": "id", "save": "id", "save_as": "id", "store": "id",
    "cmd": "send write query", "command": "do send write query", "type": "driver", "unit": "returns",
    "async": "mode", "background": "mode",
    "continue-on-error": "on_error", "ignore_errors": "on_error",
    "on_fail": "on_error", "on_failure": "on_error", "title": "name",
    "schritte": "steps", "étapes": "steps", "etapes": "steps", "geräte": "devices", "appareils": "devices",
    "wiederhole": "repeat", "répéter": "repeat", "warte": "wait", "warten": "wait", "attendre": "wait",
    "wenn": "if", "falls": "if", "si": "if", "dann": "then", "alors": "then",
    "sonst": "else", "sinon": "else",
    "race": "any", "together": "parallel",
    "version": "labrun", "protocol": "name",
    "choice": "string", "choices": "enum", "options": "enum", "values": "enum",
    "even": "e", "odd": "o",
    "float": "number", "double": "number", "int": "integer", "str": "string", "text": "string",
    "bool": "boolean", "list": "array", "length": "quantity", "duration": "quantity",
}  # fmt: skip
"""Words from other languages for what has a different name here, or one of two."""


INSTEAD = {
    "finally": "`finally` belongs to the protocol: write it in the first column, beside `steps`",
    "wait_until": 'write `wait: {until: "08:00"}`',
    "every": "steps with `watch: [{every: 10 s, when: ..., then: ...}]` are looked after while they run; "
    "`while` with a `wait` among its steps does them again and again",
    "elif": "write `else: [{if: ..., then: [...]}]`",
    "elseif": "write `else: [{if: ..., then: [...]}]`",
    "try": "a step has its own `fallback: [...]`, which runs where it fails, and its own `retry: 3`",
    "needs": "steps run in the order in which they stand; `parallel: [...]` begins several together",
    "depends_on": "steps run in the order in which they stand; `parallel: [...]` begins several together",
    "run": "a run starts no programs; a function of your own in Python is one of `functions`",
    "until": "`while: ${{ ... }}` has the condition under which it goes on",
}
"""What is written in place of a key that other languages have, where that is more than another word."""


def closest(name: str, options: Iterable[str]) -> str | None:
    """The option that looks most like the name or means the same; None if there is none."""
    known = [option for option in options if isinstance(option, str)][:2000]
    folded = {option.casefold(): option for option in known}
    if len(name) > 80:
        return None
    meant = MEANT.get(name.casefold(), "").split()
    for one in meant:
        if one in folded:
            return folded[one]
    from difflib import get_close_matches  # not at the top: most files have no mistyped names

    cutoff = 0.8 if meant else 0.6  # what is a word elsewhere is hardly a misspelt one
    found = get_close_matches(name.casefold(), folded, n=1, cutoff=cutoff)
    return folded[found[0]] if found else None


def did_you_mean(name: str, options: Iterable[str], *, prefix: str = "") -> str:
    """`; did you mean move_to?`, or nothing where no option comes close."""
    found = closest(name, options)
    return f"; did you mean {prefix}{found}?" if found else ""


def listed(names: Iterable[str], limit: int = 12, *, last: str = "and") -> str:
    """`a, b and c`; cut short if there are too many."""
    known = list(names)
    if len(known) > limit:
        return f"{', '.join(known[:limit])} and {len(known) - limit} more"
    if len(known) > 1:
        return f"{', '.join(known[:-1])} {last} {known[-1]}"
    return known[0] if known else "none"
