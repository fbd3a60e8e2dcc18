"""What of a lab may be passed on with a run."""

from labrun.schemas.lab import without_secrets


def test_tokens_passwords_headers_and_logins_are_left_out():
    login = [{"after": "login: ", "send": "lab"}, {"after": "welcome"}]
    lab = {
        "devices": {
            "a": {"url": "http://10.0.0.7:4101", "token": "secret"},
            "b": {"driver": "http", "config": {"url": "http://b", "headers": {"X-Key": "secret"}}},
            "c": {"driver": "text", "config": {"login": login, "echo": True}},
            "d": {"driver": "opcua", "config": {"user": "lab", "password": "secret"}},
            "e": {"driver": "sim_gantry"},
            "f": {"driver": "apprise", "config": {"to": {"ada": "mailto://ada:secret@lab.org"}}},
        },
        "notify": {"to": ["mailto://ada:secret@lab.org"]},
    }

    assert "notify" not in without_secrets(lab)
    assert without_secrets(lab)["devices"] == {
        "a": {"url": "http://10.0.0.7:4101"},
        "b": {"driver": "http", "config": {"url": "http://b", "headers": {"X-Key": "***"}}},
        "c": {
            "driver": "text",
            "config": {"login": [{"after": "login: ", "send": "***"}, {"after": "welcome"}], "echo": True},
        },
        "d": {"driver": "opcua", "config": {"user": "lab", "password": "***"}},
        "e": {"driver": "sim_gantry"},
        "f": {"driver": "apprise", "config": {"to": {"ada": "***"}}},
    }  # fmt: skip
