"""Parameters are declared once, without contradiction, and get values that fit.

E220. `-p NAME=VALUE` sets a parameter that the protocol declares. A misspelt one would leave the
default in force, and the run would measure something else than was asked for.

Passes with -p depth=2:

    params: {depth: {type: quantity, unit: mm, default: 1 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {z: "${{ params.depth }}"}}

Fails with -p dept=2:

    params: {depth: {type: quantity, unit: mm, default: 1 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {z: "${{ params.depth }}"}}

E221. A value is of the parameter's type, a quantity of its dimension: `2 s` is no depth.

Passes:

    params: {depth: {type: quantity, unit: mm, default: 1 cm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {z: "${{ params.depth }}"}}

Fails:

    params: {depth: {type: quantity, unit: mm, default: 2 s}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {z: "${{ params.depth }}"}}

E222. A value keeps within the minimum, the maximum, the pattern and the choices that its
declaration gives, the default as much as any other.

Passes:

    params: {gas: {type: string, enum: [argon, helium], default: argon}}
    steps:
      - log: Purged with ${{ params.gas }}

Fails:

    params: {gas: {type: string, enum: [argon, helium], default: aragon}}
    steps:
      - log: Purged with ${{ params.gas }}

E223. A parameter without a default needs a value when the protocol runs.

Passes with -p sample=SPD-07:

    params: {sample: {type: string}, who: {type: string, default: me}}
    steps:
      - log: ${{ params.who }} measures ${{ params.sample }}

Fails with -p who=you:

    params: {sample: {type: string}, who: {type: string, default: me}}
    steps:
      - log: ${{ params.who }} measures ${{ params.sample }}

E224. A declaration that contradicts itself fits no value, or says something that is never looked
at: a minimum above the maximum, a pattern for a number, a unit that nobody knows.

Passes:

    params: {depth: {type: quantity, unit: mm, minimum: 1 mm, maximum: 2 cm, default: 2 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {z: "${{ params.depth }}"}}

Fails:

    params: {depth: {type: quantity, unit: mm, minimum: 1 mm, maximum: 20 um, default: 2 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {z: "${{ params.depth }}"}}

W223. `labrun check` looks at a protocol before anybody has chosen values; it says which ones will
be wanted.

Passes:

    params: {sample: {type: string, default: demo}}
    steps:
      - log: ${{ params.sample }}

Fails:

    params: {sample: {type: string}}
    steps:
      - log: ${{ params.sample }}
"""
