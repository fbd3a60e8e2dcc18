"""The lab has a device for every role, and says nothing of its devices that their contracts do not.

E130. A contract that a lab brings along is a YAML file of the form that every contract has, and
every device keeps one that is known.

Passes as a lab:

    devices:
      gantry: {contract: gantry@1, driver: sim_gantry}

Fails as a lab:

    devices:
      gantry: {contract: gantrie@1, driver: sim_gantry}

E131. `limits` narrow what a contract allows, for this bench. A limit on a parameter that no action
has, or in a unit of another dimension, would protect nothing.

Passes as a lab:

    devices:
      gantry: {contract: gantry@1, driver: sim_gantry, limits: {x: {maximum: 40 cm}}}

Fails as a lab:

    devices:
      gantry: {contract: gantry@1, driver: sim_gantry, limits: {x: {maximum: 40 s}}}

E208. A contract is named with its version, such as gantry@1, and is one that ships or one that the
lab brings along.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home

Fails:

    devices: {gantry: gantrie@1}
    steps:
      - do: gantry.home

E209. A role is played by the device of its name, or by the only device of the lab that keeps the
contract. Where there is none, or a choice, somebody has to say which.

Passes with --bind left=back:

    devices: {left: gantry@1}
    steps:
      - do: left.home

Fails:

    devices: {left: gantry@1}
    steps:
      - do: left.home

Beside it, lab.yaml:

    devices:
      front: {contract: gantry@1, driver: sim_gantry}
      back: {contract: gantry@1, driver: sim_gantry}

E210. `--bind ROLE=DEVICE` names a role of the protocol and a device of the lab that keeps the
role's contract.

Passes with --bind stage=gantry:

    devices: {stage: gantry@1}
    steps:
      - do: stage.home

Fails with --bind stage=libs:

    devices: {stage: gantry@1}
    steps:
      - do: stage.home
"""
