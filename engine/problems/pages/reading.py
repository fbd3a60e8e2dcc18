"""A file can be read as YAML, without guessing what was meant.

E100. A protocol is a text file in UTF-8 that is not empty.

Passes:

    steps:
      - log: hello

Fails:

    # everything is still to be written

E101. YAML is a way of writing lists and fields. If a bracket, a quote or an indentation is
wrong, it is unclear what belongs to what.

Passes:

    summary: "first: second"
    steps:
      - log: hello

Fails:

    summary: first: second
    steps:
      - log: hello

E102. Other programs silently keep the last of two equal keys; one of two timeouts would be
ignored.

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

E103. A key is a word. YAML allows a list or a mapping as a key, but protocols do not.

Passes:

    params: {depth: {type: number, default: 1}}
    steps:
      - log: ${{ params.depth }}

Fails:

    params: {[depth, width]: {type: number, default: 1}}
    steps:
      - log: hello

E104. `*name` repeats what `&name` marked earlier in the same file.

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

E105. A tag (`!text`) asks a program to treat a value specially. Protocols are plain data: the
place of a value determines its type.

Passes:

    summary: hello
    steps:
      - log: hello

Fails:

    summary: !text hello
    steps:
      - log: hello

E106. No device can go to NaN or to infinity, and half of a character (`\\ud83d`) is not readable
text.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: 730}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: .inf}}

E107. A file holds one protocol; `---` begins another document, and it is unclear which should run.

Passes:

    steps:
      - log: hello

Fails:

    steps:
      - log: hello
    ---
    steps:
      - log: good bye

E108. A protocol of a thousand lines has forty thousand characters and ten levels. A file a
thousand times as large comes from a faulty program.

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

E109. An expression is `${{ ... }}`. Without the `$`, YAML reads it as plain text or a mapping, and
a ` #` inside it begins a comment.

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

W101. Text in double braces, or in `${ }`, is not changed, nor is `steps.weight.mass` without any. Other
programs replace such text with a value, so it may be a mistake. A `;` or `,` beside `${{ }}` makes text of
what would be a number.

Passes:

    params: {sample: {type: string, default: core}}
    steps:
      - log: Measuring ${{ params.sample }}

Fails:

    params: {sample: {type: string, default: core}}
    steps:
      - log: Measuring {{ sample }} (${{ params.sample }})

W102. `010` is ten here, eight in YAML 1.1, and often meant as a name.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: 10}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: 010}}

W103. A word processor turns straight quotes into curly ones. YAML treats them as letters, so they
become part of the text.

Passes:

    steps:
      - log: "ready"

Fails:

    steps:
      - log: “ready”

W105. What follows a space and a `#` is a comment, also where it is the number of a sample.

Passes:

    steps:
      - log: "sample #5"

Fails:

    steps:
      - log: sample #5

W104. In YAML, a word that begins with & in front of a value is its name, by which `*` repeats it. The word
is no part of the value.

Passes:

    steps:
      - log: "&c is ready"

Fails:

    steps:
      - log: &c is ready
"""
