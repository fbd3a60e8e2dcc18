"""A report tells a part each time; the reader remembers the rest."""

import pytest

from labrun.drivers.grbl.report import ReportReader


def test_the_offset_is_remembered_between_the_reports_that_tell_it():
    reader = ReportReader()
    first = reader.read("<Idle|MPos:-5.000,-6.000,-7.000|FS:0,0>")
    reader.read("<Idle|MPos:-5.000,-6.000,-7.000|FS:0,0|WCO:-805.000,-725.000,-5.000>")
    later = reader.read("<Run|MPos:-4.000,-6.000,-7.000|FS:2500,0|Ov:100,100,100>")

    assert first.work is None
    assert later.work == (801.0, 719.0, -2.0)
    assert (later.state, later.feed_mm_per_min) == ("Run", 2500.0)


def test_a_controller_that_reports_work_positions_is_understood_once_the_offset_is_known():
    reader = ReportReader()
    unknown = reader.read("<Idle|WPos:1.000,2.000,3.000|Bf:15,128>")
    known = reader.read("<Idle|WPos:1.000,2.000,3.000|WCO:-10.000,-20.000,-30.000>")

    assert unknown.machine is None
    assert known.machine == (-9.0, -18.0, -27.0)


def test_inches_become_millimetres():
    reader = ReportReader()
    reader.inches = True

    assert reader.read("<Idle|MPos:1.0000,0.0000,-1.0000>").machine == (25.4, 0.0, -25.4)


@pytest.mark.parametrize(
    "damaged",
    ["<Idle|MPos:1.000,2.000>", "<Idle|MPos:1.000,2.0#0,3.000>", "<Idle|MPos:1.000,2.000,3>"],
)
def test_a_damaged_report_is_none(damaged):
    assert ReportReader().read(damaged) is None


def test_more_axes_and_fields_of_grblhal_do_no_harm():
    report = ReportReader().read("<Hold:0|MPos:1.000,2.000,3.000,4.000|Bf:100,1024|A:S|TLR:0>")

    assert (report.state, report.part, report.machine) == ("Hold", 0, (1.0, 2.0, 3.0, 4.0))
    assert report.still
