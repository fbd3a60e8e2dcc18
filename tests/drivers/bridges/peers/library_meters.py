"""The pump of `line_peer.py` as an instrument of no library and of two, imported where they are asked for."""

import socket


def qcodes_pump(name, address, **options):
    """QCoDeS' function in the place of a class."""
    from qcodes.instrument import VisaInstrument  # pyright: ignore[reportMissingImports]

    class Pump(VisaInstrument):
        def dispense(self, volume):
            self.write(f"DISP {volume}")
            self.ask("*OPC?")

    pump = Pump(name, address, terminator="\n", timeout=8, visalib="@py", **options)
    pump.add_parameter("voltage", get_cmd="MEAS:VOLT:DC?", get_parser=float, unit="V")
    pump.add_parameter("count", get_cmd="COUN?", get_parser=int)
    pump.add_parameter("range", set_cmd="VOLT:RANG {}", get_cmd="VOLT:RANG?", unit="V")
    return pump


def pymeasure_pump(address, **options):
    """PyMeasure's function in the place of a class."""
    from pymeasure.instruments import Instrument  # pyright: ignore[reportMissingImports]

    class Pump(Instrument):
        voltage = Instrument.measurement("MEAS:VOLT:DC?", "Get the voltage in V.")
        count = Instrument.measurement("COUN?", "Get what was dispensed.", cast=int)
        range = Instrument.control("VOLT:RANG?", "VOLT:RANG %g", "Control the range in V.")

        def dispense(self, volume):
            self.write(f"DISP {volume}")
            self.ask("*OPC?")

    ends = {"read_termination": "\n", "write_termination": "\n", "timeout": 8000}
    return Pump(address, "pump", **ends, **options)


class SocketPump:
    """A class as a stranger writes one: for `driver: python`, of no library at all."""

    def __init__(self, where):
        host, _, port = where.partition(":")
        self._socket = socket.create_connection((host, int(port)), timeout=8)
        self._lines = self._socket.makefile("rw", encoding="utf-8", newline="\n")

    def _ask(self, line):
        self._lines.write(f"{line}\n")
        self._lines.flush()
        answer = self._lines.readline()
        if not answer:
            raise ConnectionError("it has closed the connection")
        return answer.strip()

    @property
    def voltage(self):
        return float(self._ask("MEAS:VOLT:DC?").split()[0])

    @property
    def count(self):
        return int(self._ask("COUN?"))

    @property
    def range(self):
        return float(self._ask("VOLT:RANG?"))

    @range.setter
    def range(self, volts):
        self._lines.write(f"VOLT:RANG {volts:g}\n")
        self._lines.flush()

    def dispense(self, volume):
        self._lines.write(f"DISP {volume:g}\n")
        self._ask("*OPC?")

    def close(self):
        self._socket.close()
