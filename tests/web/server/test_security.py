"""Who may ask: hosts, origins, sessions, tokens; and what every answer says to the browser."""

import asyncio
import os
import stat
import subprocess
import sys
from functools import partial

import httpx
import pytest
from fastapi import Response

from labrun.drivers.server import same_user, tokens
from labrun.web.access.sessions import Sessions

pytestmark = pytest.mark.slow

SECRET = "correct-horse-battery"
get, post = partial(httpx.get, timeout=500), partial(httpx.post, timeout=500)


@pytest.fixture(scope="module")
def guarded(lasting):
    """A server for other machines, with a token."""
    return lasting(arguments=["--host", "0.0.0.0", "--token", SECRET])


@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:8321", "127.0.0.1.evil.example", "192.168.1.7", "[::2]", ""],
)
def test_a_name_that_is_not_ours_is_refused_so_that_no_site_can_rebind_to_us(shared, host):
    answer = get(f"{shared.url}/api/v1/session", headers={"Host": host})

    assert answer.status_code in (400, 421)
    assert "set-cookie" not in answer.headers


@pytest.mark.parametrize("host", ["localhost", "LOCALHOST", "127.0.0.1", "127.0.0.9", "[::1]"])
def test_names_of_this_machine_are_ours(shared, host):
    answer = get(f"{shared.url}/api/v1/session", headers={"Host": host})

    assert answer.status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"}, {"Origin": "null"}, {"Sec-Fetch-Site": "cross-site"},
        {"Origin": "http://127.0.0.1:1"},
    ],
)  # fmt: skip
def test_pages_of_other_sites_may_ask_nothing_not_even_to_stop(shared, page, headers):
    answers = [
        page.post("/stop", headers=headers), page.get("/runs", headers=headers),
        page.put("/protocols/x.yaml", json={"text": ""}, headers=headers),
    ]  # fmt: skip

    assert {answer.status_code for answer in answers} == {403}
    assert page.get("/runs", headers={"Origin": shared.url}).status_code == 200


def test_the_cookie_is_for_this_site_and_not_for_scripts(shared):
    answer = get(shared.entry)
    cookie = answer.headers["set-cookie"].lower()

    assert "httponly" in cookie and "samesite=strict" in cookie and "path=/" in cookie


def test_the_token_in_an_address_signs_a_browser_in_and_it_goes_on_without_it(shared):
    with httpx.Client(timeout=500) as browser:
        entered = browser.get(f"{shared.url}/runs?find=K17&token={shared.token}")
        session = browser.get(f"{shared.url}/api/v1/session").json()

    assert entered.status_code == 303 and entered.headers["location"] == "/runs?find=K17"
    assert entered.headers["cache-control"] == "no-store"
    assert session["signed_in"] and session["token_needed"]


@pytest.mark.parametrize(
    ("address", "goes_on_to"),
    [("/?token=guess", "/"), ("//evil.example/%5c?token=guess", "/evil.example/%5C")],
)
def test_a_guess_in_an_address_signs_nobody_in_and_leads_to_no_other_site(
    shared, address, goes_on_to
):
    answer = get(shared.url + address)

    assert answer.status_code == 303 and answer.headers["location"] == goes_on_to
    assert "set-cookie" not in answer.headers


def test_the_made_token_is_for_this_user_alone_and_found_by_this_user(shared):
    path = tokens._path(shared.url)
    again = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "web", "--no-browser", "--port",
         shared.url.rpartition(":")[2]],
        capture_output=True, text=True, cwd=shared.folder,
    )  # fmt: skip

    assert os.name == "nt" or stat.S_IMODE(path.stat().st_mode) == 0o600
    assert tokens.found(shared.url) == shared.token and len(shared.token) >= tokens.LEAST
    assert again.returncode == 4 and f"open {shared.entry}, or" in again.stderr


def test_a_ticket_lets_one_browser_in_once(tmp_path):
    sessions = Sessions(tmp_path / "secret", SECRET, made=True)

    async def story():
        ticket = sessions.ticket()
        return [await sessions.enters(given) for given in (ticket, ticket, SECRET)]

    assert asyncio.run(story()) == [True, False, True]


def test_only_a_chosen_token_signs_browsers_out_when_it_changes(tmp_path):
    def signed(token, made):
        response = Response()
        Sessions(tmp_path / "secret", token, made=made).set_cookie(response)
        name, _, value = response.headers["set-cookie"].partition(";")[0].partition("=")
        return {name: value}

    def knows(token, made, cookies):
        return Sessions(tmp_path / "secret", token, made=made).knows(cookies, {})

    assert knows("made-at-the-next-start", True, signed("made-at-this-start", True))
    assert not knows("another-chosen-word", False, signed("a-word-that-was-chosen", False))
    # what an open server gave to everybody is worth nothing once a token is wanted
    assert not knows("made-at-the-next-start", True, signed(None, False))


def test_without_a_token_by_choice_whoever_asks_is_let_in(house):
    open_to_all = house(arguments=["--no-token"])

    assert open_to_all.token == ""
    assert get(f"{open_to_all.url}/api/v1/session").json()["signed_in"]
    assert open_to_all.client().get("/runs").status_code == 200


def test_nothing_but_the_stop_is_answered_without_a_session(shared):
    paths = ["devices", "runs", "protocols", "settings", "schema", "control", "trash"]
    answers = [get(f"{shared.url}/api/v1/{path}") for path in paths]
    name = next(iter(shared.client().cookies))
    forged = get(f"{shared.url}/api/v1/runs", headers={"Cookie": f"{name}=a.9999999999.0000"})

    assert {answer.status_code for answer in answers} == {401} and forged.status_code == 401
    assert post(f"{shared.url}/api/v1/stop").status_code == 200
    assert get(f"{shared.url}/api/v1/openapi.json").status_code == 200


@pytest.mark.skipif(not same_user.TABLES[4].exists(), reason="the kernel does not tell")
def test_a_browser_of_this_user_needs_no_token_and_one_behind_a_proxy_does(shared):
    url = f"{shared.url}/api/v1/session"

    assert get(url).json()["signed_in"]
    assert not get(url, headers={"X-Forwarded-For": "10.0.0.9"}).json()["signed_in"]


def test_every_answer_forbids_scripts_of_others(shared, page):
    for answer in (page.get("/runs"), page.get("/nowhere"), get(shared.url)):
        policy = answer.headers["content-security-policy"]
        assert "default-src 'self'" in policy and "script-src 'self';" in policy
        assert "unsafe-eval" not in policy and "frame-ancestors 'none'" in policy
        assert answer.headers["x-content-type-options"] == "nosniff"


def test_elsewhere_the_token_is_wanted(guarded):
    client = guarded.client()
    before = client.get("/session").json()
    refused = client.get("/devices")
    wrong = client.post("/session", json={"token": "guess"})
    right = client.post("/session", json={"token": SECRET})
    inside = client.get("/devices")
    program = get(f"{guarded.url}/api/v1/devices", headers={"Authorization": f"Bearer {SECRET}"})
    guess = {"Authorization": "Bearer guess"}
    guesses = [get(f"{guarded.url}/api/v1/{path}", headers=guess) for path in ("session", "runs")]
    stop = post(f"{guarded.url}/api/v1/stop", headers=guess)
    client.delete("/session")

    assert before == before | {"signed_in": False, "token_needed": True}
    assert (refused.status_code, wrong.status_code, right.status_code) == (401, 401, 200)
    assert inside.status_code == program.status_code == 200
    assert client.get("/devices").status_code == 401
    # each has met the brake, in which a wrong token is held up
    assert [(a.status_code, a.json()["code"]) for a in guesses] == [(401, "WRONG_TOKEN")] * 2
    assert wrong.json()["code"] == "WRONG_TOKEN" and stop.status_code == 200


def test_addresses_are_ours_elsewhere_and_names_of_others_are_not(guarded):
    url = f"{guarded.url}/api/v1/session"

    assert get(url, headers={"Host": "10.0.0.7:8321"}).status_code == 200
    assert get(url, headers={"Host": "evil.example"}).status_code == 421


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--host", "0.0.0.0"], "a token is required"),
        (["--host", "0.0.0.0", "--token", "short"], "easily guessed"),
        (["--no-token", "--token", SECRET], "give one of the two"),
        (["--demo", "--lab", "x.yaml"], "has its own"),
        (["no-such-folder"], "is not a folder"),
    ],
)
def test_a_careless_start_is_refused_with_a_sentence(tmp_path, options, words):
    told = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "web", "--no-browser", "--port", "0", *options],
        capture_output=True, text=True, cwd=tmp_path,
        env={k: v for k, v in os.environ.items() if k != "LABRUN_WEB_TOKEN"},
    )  # fmt: skip

    assert told.returncode == 2
    assert words in told.stderr and "Traceback" not in told.stderr


def test_no_secret_is_in_what_the_server_says_or_leaves_readable(guarded):
    state = guarded.folder / "protocols" / ".labrun" / "web"
    client = guarded.client()
    client.post("/session", json={"token": SECRET})
    client.get("/devices")
    texts = [
        path.read_bytes() for path in state.rglob("*")
        if path.is_file() and path.suffix in (".log", ".json", ".yaml")
    ]  # fmt: skip

    assert all(SECRET.encode() not in text for text in texts)
    assert stat.S_IMODE((state / "secret").stat().st_mode) == 0o600
    assert stat.S_IMODE((state / "bench" / "lab.yaml").stat().st_mode) == 0o600
    assert SECRET not in guarded.stop()


def test_a_page_that_is_not_built_says_how(shared):
    answer = get(shared.url)

    assert answer.status_code in (200, 503)
    assert answer.status_code == 200 or "a wheel" in answer.text
    assert post(shared.url).status_code == 405
