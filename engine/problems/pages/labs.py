"""The lab has a device for every role, and its settings agree with the contracts of its devices.

E130. A contract of the lab's own is a YAML file in the same form as every contract, and every
device has a known contract. One that has the name of a contract that ships takes its place: a warning.

Passes as a lab:

    devices:
      gantry: {contract: gantry@1, driver: sim_gantry}

Fails as a lab:

    devices:
      gantry: {contract: gantrie@1, driver: sim_gantry}

E131. `limits` narrow what a contract allows on this bench. A limit on a parameter that no action
has, or in a unit of another dimension, would protect nothing.

Passes as a lab:

    devices:
      gantry: {contract: gantry@1, driver: sim_gantry, limits: {x: {maximum: 40 cm}}}

Fails as a lab:

    devices:
      gantry: {contract: gantry@1, driver: sim_gantry, limits: {x: {maximum: 40 s}}}

E132. Where the `config` of a device says its actions (`driver: scpi`, `text`, `modbus`, `http`), they
fit one another: a text that is sent names parameters of its action, a probe and a count are actions,
a unit is one, and a contract with a file of its own has the same actions. Of every other driver that
ships, a `config` has the keys that it needs, no other than it knows, and values that it takes
(`baud: fast` is none).

Passes as a lab:

    devices:
      source:
        driver: scpi
        config:
          resource: 10.0.0.5:5025
          actions:
            set_range: {write: "VOLT:RANG {range:g}", params: {range: {unit: V}}}

Fails as a lab:

    devices:
      source:
        driver: scpi
        config:
          resource: 10.0.0.5:5025
          actions:
            set_range: {write: "VOLT:RANG {rnge:g}", params: {range: {unit: V}}}

W130. A driver is one that ships with labrun, one that an installed package brings, or a class in a file
of one's own. The protocol can be checked without it, not run: a warning.

Passes as a lab:

    devices:
      gantry: {contract: gantry@1, driver: sim_gantry}

Fails as a lab:

    devices:
      gantry: {contract: gantry@1, driver: sim_gantri}

W131. A serial port, and the address of an instrument, is that of one device: the second cannot open it, or
each reads what the other has asked. Several on one line each say `shared: true`. Units behind one Modbus
gateway are no fault.

Passes as a lab:

    devices:
      left: {contract: gantry@1, driver: grbl, config: {port: /dev/ttyUSB0}}
      right: {contract: gantry@1, driver: grbl, config: {port: /dev/ttyUSB1}}

Fails as a lab:

    devices:
      left: {contract: gantry@1, driver: grbl, config: {port: /dev/ttyUSB0}}
      right: {contract: gantry@1, driver: grbl, config: {port: /dev/ttyUSB0}}

W133. Tables and protocols may be named that lie in one of a lab's `folders`. One that is not there, or is
a file, holds nothing; it may be a drive that is not mounted now, so it is a warning.

Passes as a lab:

    folders: [.]
    devices:
      gantry: {contract: gantry@1, driver: sim_gantry}

Fails as a lab:

    folders: [./tabels]
    devices:
      gantry: {contract: gantry@1, driver: sim_gantry}

E208. A contract is named with its version, such as gantry@1, and must be one that ships with
labrun or one of the lab's own.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home

Fails:

    devices: {gantry: gantrie@1}
    steps:
      - do: gantry.home

E209. A role is played by the device of the same name, or by the only device of the lab with that
contract. If there is none, or more than one, a person must choose the device.

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

E210. `--bind ROLE=DEVICE` names a role of the protocol and a device of the lab that has the
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
