"""`labrun docs` opens the manual of this installation, or says why there is none."""

import webbrowser

import pytest
import typer

from labrun.engine.commands.docs import docs
from labrun.system import page


def test_it_prints_where_the_manual_is_and_opens_it_as_a_file(tmp_path, monkeypatch, capsys):
    opened = []
    monkeypatch.setattr(page, "DOCS", tmp_path)
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address) or False)
    (tmp_path / "index.html").write_text("")
    docs(no_browser=True)
    docs()
    said = capsys.readouterr()

    assert said.out == f"{tmp_path / 'index.html'}\n" * 2
    assert opened == [(tmp_path / "index.html").as_uri()]
    assert "no browser was found" in said.err


def test_where_it_was_not_built_a_sentence_says_how_to_have_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(page, "DOCS", tmp_path)
    with pytest.raises(typer.Exit) as ended:
        docs()

    assert ended.value.exit_code == 2
    assert "docs/site/build.py" in capsys.readouterr().err
