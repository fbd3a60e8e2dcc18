"""Every promise of the analyser's contract, kept by the driver of the paper's server."""

from contextlib import contextmanager

import pytest

from ..analyser_calls import KeepsAnalyserContract, case_of


@pytest.mark.slow
class TestAecp(KeepsAnalyserContract):
    case = case_of("aecp", settle_s=0.4)

    @pytest.fixture(autouse=True)
    def bench(self, aecp):
        self.aecp = aecp

    @contextmanager
    def peer(self, folder, *, slow):
        self.aecp.start(shot_s=3.0 if slow else 0.1)
        try:
            yield {
                "url": f"http://127.0.0.1:{self.aecp.port}",
                "exports": str(folder / "exports"),
                "cache": self.aecp.cache,
            }
        finally:
            self.aecp.end()

    def fired(self):
        return self.aecp.shots()

    def is_busy(self, folder):
        return (folder / "running").exists()
