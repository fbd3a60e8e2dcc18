"""Keys and values are where the protocol language expects them.

E110. An unknown key does nothing: with `tmeout: 3 s` the step has no timeout. So unknown keys are
errors everywhere.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, timeout: 60 s}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, tmeout: 60 s}

E111. Some keys are required: `labrun`, `name` and `steps` in a protocol, `steps` in a loop,
`choices` beside an `ask`.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {ask: Is the sample clamped?, choices: ["yes", "no"]}
      - do: gantry.home

Fails:

    devices: {gantry: gantry@1}
    steps:
      - ask: Is the sample clamped?
      - do: gantry.home

E112. Each key needs a value of a certain kind: a number, one of a few words, a name of letters,
digits and `_`.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, on_error: continue}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, on_error: ignore}

E113. A protocol is a mapping, and so is a step: `do: gantry.home`, not `gantry.home`.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home

Fails:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
      - gantry.home

E114. The keyword of a step says what it does: `do`, `parallel`, `foreach`, `if`, `wait` and so on.
Without one, it does nothing.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {id: zero, do: gantry.home}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {id: zero, doo: gantry.home}
      - do: gantry.home

E115. A step does one thing. With two keywords the order would be unclear; two steps, or a group,
make it clear.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
      - wait: 3 s

Fails:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
        wait: 3 s

E117. `labrun: 1` says which version of the language a protocol is written in, so that it means
the same in ten years.

Passes:

    labrun: 1
    name: page
    steps:
      - log: hello

Fails:

    labrun: 2
    name: page
    steps:
      - log: hello
"""
