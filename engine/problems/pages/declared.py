"""Parameters are declared without contradictions and get values that fit.

E220. `-p NAME=VALUE` sets a parameter that the protocol declares. With a misspelt name the default
would stay in force, and the run would not measure what was requested.

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

E221. A value must have the parameter's type, a quantity its dimension: `2 s` is not a depth.

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

E222. A value must fit the minimum, the maximum, the pattern and the choices in its declaration;
so must the default.

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

E224. A declaration that contradicts itself fits no value, or contains something that is never
used: a minimum above the maximum, a pattern for a number, an unknown unit.

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

W221. Milli and mega are the same letter, small and large: 5 MW is a thousand million times 5 mW. Where a
value's unit is the wanted one but for that, it is told, whatever the range; write the value in the unit
that is wanted if it is meant.

Passes:

    params: {power: {type: quantity, unit: mW, default: 5 mW}}
    steps:
      - log: ${{ params.power }}

Fails:

    params: {power: {type: quantity, unit: mW, default: 5 MW}}
    steps:
      - log: ${{ params.power }}

W223. `labrun check` checks a protocol before values are chosen; it shows which ones will be
needed.

Passes:

    params: {sample: {type: string, default: demo}}
    steps:
      - log: ${{ params.sample }}

Fails:

    params: {sample: {type: string}}
    steps:
      - log: ${{ params.sample }}
"""
