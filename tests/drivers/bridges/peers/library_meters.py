"""The pump of `line_peer.py` as an instrument of two libraries, each imported where it is asked for."""


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
