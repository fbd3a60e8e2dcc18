"""A protocol that is used by another is a readable file and never uses itself.

E120. `use: ./other.yaml` names a file relative to the protocol that contains it. The name must not
contain an expression: the file must be known before the run, so that everything in it is checked.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - use: ./home.yaml

Fails:

    devices: {gantry: gantry@1}
    steps:
      - use: ./hom.yaml
      - do: gantry.home

Beside it, home.yaml:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home

E121. A protocol that uses itself, directly or indirectly, never ends.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - use: ./home.yaml

Fails:

    devices: {gantry: gantry@1}
    steps:
      - use: ./round.yaml
      - do: gantry.home

Beside it, home.yaml:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home

Beside it, round.yaml:

    devices: {gantry: gantry@1}
    steps:
      - use: ./page.yaml
      - do: gantry.home

E122. Protocols that use others that use others multiply: 8 times 8 times 8 is 512, each of them
read, checked and built before the first action. More than 20 within each other, or 500 in all,
is a mistake; a `foreach` around one `use` does the same with one.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - repeat: 512
        steps:
          - use: ./home.yaml

Fails:

    devices: {gantry: gantry@1}
    steps:
      - use: ./eight.yaml
      - use: ./eight.yaml
      - use: ./eight.yaml
      - use: ./eight.yaml
      - use: ./eight.yaml
      - use: ./eight.yaml
      - use: ./eight.yaml
      - use: ./eight.yaml
      - do: gantry.home

Beside it, home.yaml:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home

Beside it, eight.yaml:

    steps:
      - use: ./sixty_four.yaml
      - use: ./sixty_four.yaml
      - use: ./sixty_four.yaml
      - use: ./sixty_four.yaml
      - use: ./sixty_four.yaml
      - use: ./sixty_four.yaml
      - use: ./sixty_four.yaml
      - use: ./sixty_four.yaml

Beside it, sixty_four.yaml:

    steps:
      - use: ./hello.yaml
      - use: ./hello.yaml
      - use: ./hello.yaml
      - use: ./hello.yaml
      - use: ./hello.yaml
      - use: ./hello.yaml
      - use: ./hello.yaml
      - use: ./hello.yaml

Beside it, hello.yaml:

    steps:
      - log: hello
"""
