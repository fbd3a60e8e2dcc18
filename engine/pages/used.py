"""A protocol that is used by another is a file that can be read, and never ends up using itself.

E120. `use: ./other.yaml` names a file beside the one that it stands in. It is known before the
run, so that everything in it is checked: the name holds no expression.

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

E121. A protocol that uses itself, by whatever way, never comes to an end.

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

E122. Protocols that use others that use others multiply: 8 times 8 times 8 are 512, each of them
read, checked and built before the first action. More than 20 within each other, or 500 in all,
are a mistake; a `foreach` around one `use` does the same with one.

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
