"""Every promise of the analyser's contract, kept with mouse and keyboard on a real program."""

from contextlib import contextmanager

import pytest

from ..analyser_calls import KeepsAnalyserContract, case_of


@pytest.mark.soak
class TestSciapsGui(KeepsAnalyserContract):
    case = case_of("sciaps_gui")

    @pytest.fixture(autouse=True)
    def bench(self, gui):
        self.gui = gui

    @contextmanager
    def peer(self, folder, *, slow):
        self.analyser = self.gui.start(measure_s=4.0 if slow else 0.2)
        try:
            yield self.gui.config(measure_s=20)
        finally:
            self.gui.end()

    def fired(self):
        return self.analyser.shots()

    def is_busy(self, folder):
        return self.analyser.order("state") == "busy"
