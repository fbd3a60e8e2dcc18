"""A file can be read as YAML, without guessing what was meant.

E100. Everything starts with a text file in UTF-8 that has something in it.

Passes:

    steps:
      - log: hello

Fails:

    # everything is still to be written

E101. YAML is a way of writing lists and fields. Where a bracket, a quote or an indentation is
out of place, nobody can say what belongs to what.

Passes:

    summary: "first: second"
    steps:
      - log: hello

Fails:

    summary: first: second
    steps:
      - log: hello

E102. Other programs keep the last of two equal keys and say nothing; one of two timeouts would
silently not hold.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
        timeout: 40 s

Fails:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
        timeout: 30 s
        timeout: 40 s

E103. A key is a word. A list or a mapping as a key is YAML, but no key of any protocol.

Passes:

    params: {depth: {type: number, default: 1}}
    steps:
      - log: ${{ params.depth }}

Fails:

    params: {[depth, width]: {type: number, default: 1}}
    steps:
      - log: hello

E104. `*name` repeats what `&name` marked, further up in the same file.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, retry: &twice {attempts: 2, wait: 1 s}}
      - {do: gantry.unlock, retry: *twice}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, retry: &twice {attempts: 2, wait: 1 s}}
      - {do: gantry.unlock, retry: *twise}

E105. A tag (`!text`) asks a program to make something special of a value. Protocols are plain
data: what a value is, the place where it stands says.

Passes:

    summary: hello
    steps:
      - log: hello

Fails:

    summary: !text hello
    steps:
      - log: hello

E106. No device can go to NaN or to infinity, and half of a character (`\\ud83d`) is no text that
anybody could read.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: 730}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: .inf}}

E107. A file holds one protocol; `---` begins another document. Which of them should run?

Passes:

    steps:
      - log: hello

Fails:

    steps:
      - log: hello
    ---
    steps:
      - log: good bye

E108. A protocol of a thousand lines has forty thousand characters and ten levels. What is a
thousand times as large was made by a program that went wrong.

Passes:

    summary: short
    steps:
      - log: hello

Fails:

    summary: [
        [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[
        [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[]
    steps:
      - log: hello

E109. An expression is `${{ ... }}`. Without the `$` it is plain text or a mapping to YAML, and a
` #` inside it begins a comment.

Passes:

    params: {depth: {type: quantity, unit: mm, default: 1 mm}}
    devices: {gantry: gantry@1}
    steps:
      - do: gantry.move_to
        with:
          z: ${{ params.depth }}

Fails:

    params: {depth: {type: quantity, unit: mm, default: 1 mm}}
    devices: {gantry: gantry@1}
    steps:
      - do: gantry.move_to
        with:
          z: "{{ params.depth }}"

W101. Text in double braces is left as it stands. Other programs put a value in its place, so it
is worth a look.

Passes:

    params: {sample: {type: string, default: core}}
    steps:
      - log: Measuring ${{ params.sample }}

Fails:

    params: {sample: {type: string, default: core}}
    steps:
      - log: Measuring {{ sample }} (${{ params.sample }})

W102. `010` is ten here, eight to YAML 1.1, and to a person often a name.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: 10}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: 010}}

W103. A word processor turns straight quotes into curly ones. To YAML they are letters, and become
part of the text.

Passes:

    steps:
      - log: "ready"

Fails:

    steps:
      - log: “ready”
"""
