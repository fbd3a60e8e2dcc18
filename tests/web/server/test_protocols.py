"""Protocols: listed, read, saved with revisions, kept in versions, thrown away and taken back."""

import pytest

pytestmark = pytest.mark.slow

GOOD = "labrun: 1\nname: mine\ndevices: {gantry: gantry@1}\nsteps: [{do: gantry.home, timeout: 1 min}]\n"


def test_the_list_tells_what_the_checker_and_the_runs_say(shared, page, wait_for):
    broken = GOOD.replace("gantry.home", "gantry.hmoe")
    files = {"good.yaml": GOOD, "sub/broken.yaml": broken, "lab2.yaml": "name: x\n"}
    for name, text in files.items():
        (shared.library / name).parent.mkdir(exist_ok=True)
        (shared.library / name).write_text(text)
    page.reach("gantry")
    id = page.run_of("good.yaml", checklist=[])
    page.until(id, "succeeded")

    def checked():
        told = {one["name"]: one for one in page.get("/protocols").json()}
        return None not in (one["errors"] for one in told.values()) and told

    told = wait_for(checked, "all protocols checked")

    # What says no `labrun:` is no protocol.
    assert files.keys() & told.keys() == {"good.yaml", "sub/broken.yaml"}
    assert told["good.yaml"]["title"] == "mine" and told["good.yaml"]["errors"] == 0
    assert told["good.yaml"]["runs"] == told["good.yaml"]["succeeded"] == 1
    assert told["good.yaml"]["median_s"] > 0
    assert told["sub/broken.yaml"]["errors"] == 1
    assert "home" in told["sub/broken.yaml"]["first_error"]


def test_saving_needs_the_revision_that_was_read_and_a_conflict_shows_all_three_texts(shared, page):
    page.post("/protocols", json={"name": "both.yaml", "text": GOOD})
    read = page.get("/protocols/both.yaml").json()
    first = page.put(
        "/protocols/both.yaml", json={"text": GOOD + "# a\n", "base": read["revision"]}
    )
    second = page.put(
        "/protocols/both.yaml", json={"text": GOOD + "# b\n", "base": read["revision"]}
    )
    again = page.put(
        "/protocols/both.yaml", json={"text": GOOD + "# a\n", "base": read["revision"]}
    )
    conflict = second.json()
    solved = page.put(
        "/protocols/both.yaml", json={"text": GOOD + "# a b\n", "base": conflict["theirs_revision"]}
    )

    assert first.status_code == again.status_code == solved.status_code == 200
    assert second.status_code == 409
    assert (conflict["base"], conflict["theirs"]) == (GOOD, GOOD + "# a\n")
    assert conflict["mine"] == GOOD + "# b\n"
    assert page.get("/protocols/both.yaml").json()["text"] == GOOD + "# a b\n"


def test_every_text_that_was_saved_can_be_read_again(shared, page):
    page.post("/protocols", json={"name": "v.yaml", "text": "labrun: 1\n# 0\n"})
    base = page.get("/protocols/v.yaml").json()["revision"]
    for number in (1, 2):
        text = f"labrun: 1\r\n# {number} µm\r\n"  # bytes stay as they are, line ends too
        base = page.put("/protocols/v.yaml", json={"text": text, "base": base}).json()["revision"]
    versions = page.get("/protocols/v.yaml/versions").json()
    texts = [
        page.get(f"/protocols/v.yaml/versions/{one['revision']}").json()["text"] for one in versions
    ]

    assert [one["current"] for one in versions] == [True, False, False]
    assert texts == ["labrun: 1\r\n# 2 µm\r\n", "labrun: 1\r\n# 1 µm\r\n", "labrun: 1\n# 0\n"]
    assert page.get(f"/protocols/v.yaml/versions/{'0' * 64}").status_code == 404
    assert (shared.folder / "protocols" / "v.yaml").read_bytes() == texts[0].encode()


def test_a_protocol_is_thrown_away_and_taken_back(shared, page):
    page.post("/protocols", json={"name": "old.yaml", "text": GOOD})
    thrown = page.delete("/protocols/old.yaml").json()
    gone = page.get("/protocols/old.yaml")
    stale = page.put("/protocols/old.yaml", json={"text": GOOD, "base": "0" * 64})
    trash = page.get("/trash").json()
    back = page.post(f"/trash/{thrown['id']}/restore")
    twice = page.post(f"/trash/{thrown['id']}/restore")

    assert gone.status_code == stale.status_code == twice.status_code == 404
    assert trash[0] == thrown and back.json()["text"] == GOOD
    assert page.get("/trash").json() == []


def test_new_protocols_come_from_templates_texts_others_and_runs(shared, page):
    page.reach("gantry", "libs")
    id = page.run_of("grid.yaml")
    page.until(id, "succeeded")
    templates = [one["name"] for one in page.get("/templates").json()]
    template = page.post("/protocols", json={"name": "from template", "template": "minimal"})
    copy = page.post("/protocols", json={"name": "copy.yaml", "copy_of": "grid.yaml"})
    past = page.post("/protocols", json={"name": "past", "run": id})
    exists = page.post("/protocols", json={"name": "copy", "text": GOOD})
    both = page.post("/protocols", json={"name": "x", "text": GOOD, "template": "single"})
    none = page.post("/protocols", json={"name": "y", "template": "none"})
    checked = page.post("/check", json={"text": template.json()["text"], "name": "a.yaml"}).json()

    assert "grid_scan" in templates
    assert template.status_code == 201 and template.json()["name"] == "from template.yaml"
    assert checked["ok"] and checked["title"] == "from template"
    assert (
        copy.json()["text"]
        == past.json()["text"]
        == page.get("/protocols/grid.yaml").json()["text"]
    )
    assert [a.status_code for a in (exists, both, none)] == [409, 422, 422]


@pytest.mark.parametrize(
    "name",
    [
        "..%2f..%2fetc%2fpasswd.yaml", "%2e%2e%2fx.yaml", "..%5cx.yaml", "%2fetc%2fx.yaml",
        "sub%2f..%2f..%2fx.yaml", ".hidden.yaml", "a.txt", "x.yaml%00.txt", "C:x.yaml",
        "a%2fb%2fc%2fd%2fe.yaml", "%252e%252e%252fx.yaml%2f..%2f..%2fy.yaml", ".labrun%2fsecret.yaml",
    ],
)  # fmt: skip
def test_names_that_lead_out_of_the_folder_are_refused(shared, page, name):
    answers = [
        page.get(f"/protocols/{name}"),
        page.put(f"/protocols/{name}", json={"text": GOOD}),
        page.delete(f"/protocols/{name}"),
        page.get(f"/protocols/{name}/versions"),
    ]

    assert all(answer.status_code in (404, 422) for answer in answers)
    assert all("message" in answer.json() for answer in answers)


def test_links_that_lead_out_of_the_folder_are_refused(shared, page, tmp_path):
    (tmp_path / "secret.yaml").write_text(GOOD)
    (shared.folder / "protocols" / "link.yaml").symlink_to(tmp_path / "secret.yaml")
    answer = page.get("/protocols/link.yaml")

    assert (answer.status_code, answer.json()["code"]) == (422, "WRONG_NAME")


def test_what_is_too_large_or_no_text_is_refused(shared, page):
    large = page.post("/protocols", json={"name": "large", "text": "x" * 2_000_001})
    body = page.post("/check", content=b'{"text": "' + b"x" * 4_000_001 + b'"}')
    half = page.post(
        "/protocols", content=b'{"name": "half", "text": "\\ud800"}',
        headers={"content-type": "application/json"},
    )  # fmt: skip
    (shared.folder / "protocols" / "latin.yaml").write_bytes(b"labrun: 1\n# \xff\n")
    latin = page.get("/protocols/latin.yaml")

    assert large.status_code == 422 and body.status_code == 413
    assert half.status_code == 422 and (latin.status_code, latin.json()["code"]) == (
        422,
        "NOT_TEXT",
    )


def test_an_unknown_address_and_an_unknown_field_are_answered_in_words(shared, page):
    nowhere = page.get("/nowhere")
    field = page.post("/protocols", json={"name": "z", "txet": "x"})

    assert (nowhere.status_code, nowhere.json()["code"]) == (404, "NOT_FOUND")
    assert field.status_code == 422 and "txet" in field.json()["message"]


def test_a_table_is_put_beside_its_protocol_and_told_with_its_columns(shared, page):
    page.post("/protocols", json={"name": "sub/rows.yaml", "text": GOOD})
    text = "place,x (mm)\nA,1\nB,2\n"

    def bring(name: str, text: str):
        return page.post("/tables", json={"protocol": "sub/rows.yaml", "name": name, "text": text})

    first, again, other = bring("p.csv", text), bring("p.csv", text), bring("p.csv", text + "C,3\n")
    told = page.get("/tables", params={"protocol": "sub/rows.yaml"}).json()

    assert first.status_code == 201
    columns = {"columns": ["place", "x"], "kinds": ["text", "mm"]}
    assert first.json() == {"name": "p.csv", "rows": 2, **columns, "fault": None}
    assert again.json()["name"] == "p.csv"  # the same file once more
    assert other.json()["name"] == "p_2.csv"  # what is there is never replaced
    assert [(one["name"], one["rows"]) for one in told] == [("p.csv", 2), ("p_2.csv", 3)]


@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        ("../p.csv", "a\n1\n", "WRONG_NAME"),
        ("it's.csv", "a\n1\n", "WRONG_NAME"),
        (".csv", "a\n1\n", "WRONG_NAME"),
        ("p.csv", "", "NO_TABLE"),
        ("p.xlsx", "PK\x03\x04\ufffd", "NO_TABLE"),
        ("p.csv", "a,a\n1,2\n", "NO_TABLE"),
        ("p.csv", 'a\n"\n', "NO_TABLE"),
    ],
)
def test_what_is_no_table_is_not_written(shared, page, name, text, code):
    page.post("/protocols", json={"name": "none/rows.yaml", "text": GOOD})
    told = page.post("/tables", json={"protocol": "none/rows.yaml", "name": name, "text": text})
    picture = page.post("/protocols", json={"name": "picture.yaml", "text": "\ufffdPNG\0"})

    assert (told.status_code, told.json()["code"]) == (422, code)
    assert page.get("/tables", params={"protocol": "none/rows.yaml"}).json() == []
    assert (picture.status_code, picture.json()["code"]) == (422, "NO_TEXT")
