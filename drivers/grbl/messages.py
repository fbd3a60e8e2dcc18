"""The meaning of GRBL's error and alarm numbers, each with what to do.

From the list of GRBL 1.1 (doc/csv of the firmware); the numbers above it are grblHAL's, or FluidNC's.
"""

ERRORS: dict[int, str] = {
    1: "a letter was expected; noise on the line, or another program wrote to the port",
    2: "a number is missing or unreadable; noise on the line",
    3: "unknown `$` command",
    4: "a negative value where only a positive one is allowed",
    5: "homing is off ($22=0): `$22=1` turns it on if limit switches are wired",
    6: "the step pulse is shorter than 3 microseconds ($0)",
    7: "its stored settings could not be read: check all `$` settings",
    8: "this is allowed only when it is idle and not locked",
    9: "it is locked by an alarm or in a jog: home or unlock it first",
    10: "soft limits ($20=1) need homing ($22=1)",
    11: "the line is too long",
    12: "the step rate is higher than it can generate: lower $110 to $112",
    13: "the safety door is open: close it",
    14: "the line is too long for its start-up memory",
    15: "the jog would leave the machine's travel ($130 to $132)",
    16: "a jog without `=` or with a command that a jog does not allow",
    17: "laser mode ($32=1) needs a spindle with PWM",
    18: "its reset button is pressed: release it, then unlock",
    19: "a number that has to be positive",
    20: "unknown G-code",
    21: "two G-codes of the same group in one line",
    22: "no feed rate was set",
    23: "a whole number is needed",
    24: "two commands that both use the axes in one line",
    25: "a G-code word appears twice",
    26: "no axis is named",
    27: "the line number is out of range",
    28: "a G-code word that the command needs is missing",
    29: "work coordinates G59.1 to G59.3 are not supported",
    30: "G53 works with G0 and G1 only",
    31: "axes are named that the command does not use",
    32: "an arc names no axis of its plane",
    33: "the arc cannot be drawn",
    34: "the arc's radius is not possible",
    35: "the arc names no centre",
    36: "unused G-code words were left over",
    37: "the tool length offset is for the Z axis only",
    38: "the tool number is too high",
    39: "a parameter is out of range",
    40: "a tool change is waiting",
    41: "the spindle is not running",
    42: "an arc or cycle that its plane does not allow",
    43: "the feed is higher than this motion allows",
    44: "the spindle cannot turn at this speed",
    45: "a limit switch is engaged: move off it first",
    46: "it must be homed before anything else",
    47: "the tool is not known to it",
    48: "two words contradict each other",
    49: "its self-test failed: switch it off and on",
    50: "the emergency stop is pressed: release it, then unlock",
    51: "a motor driver reports a fault: switch the motors' power off and on",
    52: "the value is out of the setting's range",
    53: "the setting is turned off",
    54: "the retract height is below where it began",
    55: "its homing settings contradict each other ($22, $44 to $46)",
    56: "the work coordinate system is locked",
    58: "the output is in use, or not there",
    60: "no memory card is inserted",
    77: "it wants a password ($ME, or its network settings)",
    78: "this user may not do that",
    79: "the emergency stop is pressed: release it, then unlock",
}

ALARMS: dict[int, str] = {
    1: "a limit switch was hit; the motor was cut off in mid-step and the position is lost. "
    "Check what is in the way, unlock, jog off the switch, home",
    2: "the move would have left the machine's travel (soft limit). Unlock, and home",
    3: "it was reset while it moved; steps may be lost. Home it",
    4: "the probe was not in the state that probing starts from",
    5: "the probe made no contact within its travel",
    6: "homing was aborted by a reset",
    7: "homing was aborted: the safety door is open. Close it, home again",
    8: "homing could not get off the limit switch: raise the pull-off ($27) or check the wiring",
    9: "homing did not find the limit switch: check the switch, its wiring ($5) and $130 to $132",
    10: "the emergency stop is pressed. Release it, unlock, home",
    11: "it must be homed. Home it",
    12: "a limit switch is engaged. Move off it, home",
    13: "the probe touched where nothing was to be probed. See what it touches, unlock, home",
    14: "the spindle did not answer",
    15: "the second limit switch of an axis failed",
    16: "its self-test failed: switch it off and on",
    17: "a motor driver reports a fault: switch the motors' power off and on",
    18: "homing failed. Home it again",
    19: "a part of it on its bus (Modbus) did not answer",
    20: "its board of more inputs and outputs failed",
    21: "its stored settings could not be read: check all `$` settings",
    22: "lines came faster than it could take them. Home it",
}


COMMON_ERRORS, COMMON_ALARMS = 38, 9
"""Up to these numbers grblHAL and FluidNC mean the same as GRBL."""

FLUIDNC_ERRORS: dict[int, str] = {
    39: "a parameter's number is out of range",
    40: "a limit switch or control input is engaged: release it",
    110: "it wants a password, or this user may not do that",
    120: "another connection is running a file on it",
    130: "the jog was cancelled",
    151: "its configuration cannot be changed so while it runs",
    152: "its configuration is invalid: its start-up messages (`$SS`) say what",
    162: "the setting cannot be changed",
}

UNHOMED = 14
FLUIDNC_ALARMS: dict[int, str] = {
    10: "the spindle did not answer",
    11: "a limit switch or control input was engaged when it started. Release it, unlock, home",
    12: "more than one limit switch was engaged. Move off them by hand, home",
    13: "the probe stopped it. See what it touches, unlock, home",
    UNHOMED: "it must be homed. Home it",
    15: "it has just started. Home it",
    16: "a board of more inputs and outputs restarted. Home it",
    17: "a line of a file or macro on it failed. Unlock, and home",
    18: "the probe touched where nothing was to be probed. See what it touches, unlock, home",
}


def error_words(code: int, firmware: str = "") -> str:
    """`error:9` with its meaning."""
    own = "FluidNC" in firmware and code > COMMON_ERRORS
    known = FLUIDNC_ERRORS if own else ERRORS
    return f"error:{code} ({known.get(code, 'a number that labrun does not know')})"


def is_unhomed(code: int, firmware: str) -> bool:
    """FluidNC's lock at power-up, told as an alarm, at a time of its own: it answers as before."""
    return "FluidNC" in firmware and code == UNHOMED


def alarm_words(code: int, firmware: str = "") -> str:
    """`ALARM:1` with its meaning and what to do."""
    own = "FluidNC" in firmware and code > COMMON_ALARMS
    known = FLUIDNC_ALARMS if own else ALARMS
    return f"ALARM:{code}: {known.get(code, 'a number that labrun does not know')}"
