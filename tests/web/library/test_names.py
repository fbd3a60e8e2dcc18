"""Names of protocols, as the page may give them."""

import pytest

from labrun.web.library.names import wrong_name


@pytest.mark.parametrize("name", ["con.yaml", "lpt1/scan.yaml", "what?.yaml", "old./scan.yaml"])
def test_a_name_that_no_file_has_on_windows_is_refused_there(name, monkeypatch):
    assert wrong_name(name) == ""
    monkeypatch.setattr("labrun.web.library.names.WINDOWS", True)
    assert wrong_name(name) == "on Windows no file can have it"
