"""Verbs that summaries of contracts start with; otherwise the action's name is used."""

VERBS = frozenset({
    "add", "adjust", "align", "apply", "aspirate", "bring", "calibrate", "carry", "centre",
    "check", "clean", "clear", "close", "collect", "connect", "cool", "count", "cut", "disconnect",
    "dispense", "draw", "drop", "eject", "empty", "expose", "fill", "filter", "find", "fire",
    "flush", "focus", "forget", "get", "give", "go", "grip", "halt", "hand", "heat", "hold",
    "home", "illuminate", "inject", "insert", "keep", "lay", "leave", "lift", "load", "lock",
    "look", "lower", "make", "mark", "measure", "melt", "mix", "move", "name", "open", "pick",
    "place", "point", "pour", "press", "print", "pull", "pump", "purge", "push", "put", "raise",
    "read", "recall", "record", "release", "remove", "report", "reset", "rest", "rinse", "rotate",
    "run", "sample", "save", "scan", "seal", "select", "send", "separate", "set", "shake", "shut",
    "sleep", "spin", "spray", "spread", "stand", "start", "stay", "stir", "stop", "store",
    "switch", "take", "tare", "tell", "tilt", "turn", "unload", "unlock", "vent", "wait", "wake",
    "warm", "wash", "weigh", "withdraw", "write", "zero",
})  # fmt: skip
