"""Results: tables, maps, spectra, means, downloads, and what to measure again."""

import io
import zipfile

import numpy as np
import pytest

pytestmark = pytest.mark.slow  # each process of the tests would measure a map of its own


@pytest.fixture
def done(page, finished):
    """A browser and a run of six points that has ended."""
    return page, finished


def floats(answer):
    assert answer.status_code == 200, answer.text
    return np.frombuffer(answer.content, "<f4")


def test_tables_come_as_columns_with_units(done):
    page, id = done
    (head,) = page.get(f"/runs/{id}/tables").json()
    window = page.get(f"/runs/{id}/tables/data.csv", params={"offset": 1, "limit": 2}).json()

    assert [column["name"] for column in head["columns"]] == ["key", "x_mm", "y_mm", "Li", "fate"]
    assert head["columns"][1] == {"name": "x_mm", "unit": "mm", "numeric": True}
    assert window["total"] == 6 and window["columns"]["key"] == ["1,0", "2,0"]
    assert window["columns"]["Li"] == [1.5, 2.5]
    assert page.get(f"/runs/{id}/tables/none.csv").status_code == 404
    assert page.get(f"/runs/{id}/tables/..%2fjournal.jsonl").status_code == 404


def test_tables_are_downloaded_under_the_name_of_the_run(done):
    page, id = done
    csv = page.get(f"/runs/{id}/tables/data.csv/download")
    parquet = page.get(f"/runs/{id}/tables/data.csv/download", params={"format": "parquet"})

    assert f'filename="{id}_data.csv"' in csv.headers["content-disposition"]
    assert csv.text.startswith("key,x_mm,y_mm,Li,fate\n")
    pq = pytest.importorskip("pyarrow.parquet")
    table = pq.read_table(io.BytesIO(parquet.content))
    assert table.column("Li").to_pylist() == [0.5, 1.5, 2.5, 3.5, 4.5, 5.5]


def test_a_map_is_float32_row_by_row_with_the_key_of_each_cell(done):
    page, id = done
    told = page.get(f"/runs/{id}/maps").json()
    (head,) = told["maps"]
    cells = floats(page.get(f"/runs/{id}/maps/data.csv/Li"))

    assert head["column"] == "Li" and head["element"] and (head["width"], head["height"]) == (3, 2)
    assert head["x"] == [0, 1, 2] and head["unit"] == "mm" and head["maximum"] == 5.5
    assert told["cell_keys"]["data.csv"] == ["0,0", "1,0", "2,0", "0,1", "1,1", "2,1"]
    assert cells.tolist() == [0.5, 1.5, 2.5, 5.5, 4.5, 3.5]  # a snake comes back
    assert page.get(f"/runs/{id}/maps/data.csv/none").status_code == 404


def test_spectra_come_as_float32_and_their_axis_once(done, shared):
    page, id = done
    told = page.get(f"/runs/{id}/spectra").json()
    head = told["spectra"][3]
    answer = page.get(f"/runs/{id}/spectrum", params={"file": head["file"]})
    counts = floats(answer)
    axis = floats(page.get(f"/runs/{id}/axes/{told['axis']['id']}"))
    again = page.get(
        f"/runs/{id}/spectrum", params={"file": head["file"]},
        headers={"If-None-Match": answer.headers["etag"]},
    )  # fmt: skip
    path = shared.folder / "protocols" / "runs" / id / head["file"]
    written = np.loadtxt(path, delimiter=",", skiprows=1)

    assert head == {"file": "spectra/2_1.csv", "loop": "main/scan", "key": "2,1", "index": 3}
    assert answer.headers["x-axis"] == told["axis"]["id"]
    assert counts == pytest.approx(written[:, 1], rel=1e-6)
    assert axis == pytest.approx(written[:, 0], rel=1e-6) and len(axis) > 1000
    assert again.status_code == 304


def test_the_mean_of_a_selection_is_the_mean_of_its_spectra(done):
    page, id = done
    answer = page.post(f"/runs/{id}/mean", json={"keys": ["0,0", "1,1"]})
    two = [
        floats(page.get(f"/runs/{id}/spectrum", params={"file": f"spectra/{n}.csv"}))
        for n in ("0_0", "1_1")
    ]
    none = page.post(f"/runs/{id}/mean", json={"keys": ["9,9"]})

    assert floats(answer) == pytest.approx((two[0] + two[1]) / 2, rel=1e-5)
    assert answer.headers["x-count"] == "2"
    assert none.status_code == 404


def test_peaks_are_fitted_and_bear_their_elements(done):
    page, id = done
    file = {"file": "spectra/0_0.csv"}
    told = page.get(f"/runs/{id}/peaks", params={**file, "elements": ["Si", "Al"]}).json()
    curves = floats(page.get(f"/runs/{id}/fit", params=file))
    counts = floats(page.get(f"/runs/{id}/spectrum", params=file))
    nm = floats(page.get(f"/runs/{id}/axes/{told['axis']['id']}"))
    n = len(nm)
    background, fit, residual = curves[:n], curves[n : 2 * n], curves[2 * n :]

    assert told["peaks"] and set(told["areas"]) == {"Si", "Al"}
    assert {peak["element"] for peak in told["peaks"]} >= {e for e, a in told["areas"].items() if a}
    assert all(nm[0] <= peak["nm"] <= nm[-1] for peak in told["peaks"])
    assert fit + residual == pytest.approx(counts, rel=1e-3, abs=1)
    assert np.median(np.abs(residual)) < 0.2 * np.median(np.abs(counts - background).clip(1)) + 60
    unknown = page.get(f"/runs/{id}/peaks", params={**file, "elements": ["Xx"]})
    assert unknown.status_code == 422 and "Xx" in unknown.json()["message"]


def test_files_of_a_run_are_listed_and_fetched_but_none_outside(done):
    page, id = done
    names = {file["name"]: file["kind"] for file in page.get(f"/runs/{id}/files").json()}
    report = page.get(f"/runs/{id}/files/report.html")

    assert names["data.csv"] == "table" and names["spectra/0_0.csv"] == "spectrum"
    assert not any(name.startswith("servers") or name == "engine.lock" for name in names)
    assert "sandbox" in report.headers["content-security-policy"]
    assert report.headers["content-type"].startswith("text/html")
    for name in ("..%2f..%2flab.yaml", "%2fetc%2fpasswd", "servers%2fx", "engine.lock", "none.txt"):
        assert page.get(f"/runs/{id}/files/{name}").status_code in (404, 422), name


def test_the_zip_has_the_whole_run_without_working_state(done, shared):
    page, id = done
    answer = page.get(f"/runs/{id}/zip")
    archive = zipfile.ZipFile(io.BytesIO(answer.content))
    folder = shared.folder / "protocols" / "runs" / id
    names = {name.partition("/")[2] for name in archive.namelist()}

    assert archive.testzip() is None
    assert f'filename="{id}.zip"' in answer.headers["content-disposition"]
    assert {"protocol.yaml", "journal.jsonl", "data.csv", "lab.yaml", "launch.json"} <= names
    assert archive.read(f"{id}/journal.jsonl") == (folder / "journal.jsonl").read_bytes()
    assert not names & {"engine.lock", "control.json"}


def test_points_are_measured_again_by_the_runs_own_protocol(done, wait_for):
    page, id = done
    again = page.post(f"/runs/{id}/again", json={"keys": ["2,1", "0,0"]}).json()
    page.take("Ada", reason="again")
    page.post("/protocols", json={"name": "again.yaml", "text": again["text"]})
    checked = page.post("/check", json={"text": again["text"], "name": "again.yaml"}).json()
    second = page.run_of("again.yaml", params=again["params"])
    page.until(second, "succeeded")
    points = page.get(f"/runs/{second}/points", params={"loop": "main/scan"}).json()
    page.post("/control/release", headers=page._leased())

    assert again["points"] == 2 and again["params"] == {"sample": "core17", "pitch": "1 mm"}
    assert "# A small map" in again["text"]  # comments stay
    assert f'summary: "2 points of {id}, to be measured again"' in again["text"]
    assert "keep_going: {max_failed: 1}" in again["text"]  # 3 of 6
    assert checked["ok"], checked["problems"]
    assert points["key"] == ["0,0", "2,1"] and points["x_mm"] == [0, 2]
    assert page.post(f"/runs/{id}/again", json={"keys": ["9,9"]}).status_code == 422


def test_a_run_is_downloaded_as_nexus_and_another_format_is_refused(done):
    page, id = done
    pytest.importorskip("h5py")
    answer = page.get(f"/runs/{id}/export/nexus")
    wrong = page.get(f"/runs/{id}/export/excel")

    assert answer.content.startswith(b"\x89HDF")
    assert f'filename="{id}.nxs"' in answer.headers["content-disposition"]
    assert wrong.status_code == 404 and "mcap, nexus" in wrong.json()["hint"]


def test_a_run_is_found_labelled_and_compared_with_what_it_came_to(done):
    page, id = done
    kept = page.put(f"/runs/{id}/labels", json={"sample": "K 9", "tags": ["good"], "note": ""})
    wrong = page.put(f"/runs/{id}/labels", json={"tags": ["two words"]})
    found = page.get("/found", params={"find": "tag:good pitch=1mm"}).json()
    meant = page.get("/found", params={"find": "colour:red"})
    numbers = page.get("/found/numbers", params={"name": "data.Li", "find": "tag:good"}).json()
    own = page.get(
        "/found/numbers", params={"name": "data.Li", "find": "tag:good", "high": "2.5"}
    ).json()
    unlike = page.get("/found/numbers", params={"name": "data.Li", "low": "2 mm"})
    compared = page.get("/compared", params={"run": [id, id]}).json()
    of_sample = page.get("/samples/K 9").json()
    samples = {one["name"] for one in page.get("/samples").json()}

    assert kept.json()["tags"] == ["good"] and wrong.status_code == 422
    assert [run["id"] for run in found["runs"]] == [id] == [run["id"] for run in of_sample]
    assert found["runs"][0]["samples"] == ["K 9", "core17"] and {"K 9", "core17"} <= samples
    assert found["runs"][0]["total"] == 6 and "data.Li" in found["numbers"]
    assert meant.status_code == 422 and "there is no colour" in meant.json()["message"]
    assert numbers["runs"][0]["value"] == 3.0 and numbers["mean"] is None
    assert own["high"] == 2.5 and own["low"] is None and own["runs"][0]["out"]
    assert unlike.status_code == 422 and unlike.json()["message"].startswith("low 2 mm: ")
    assert compared["params"] == {} and compared["values"]["data.Li"] == [3.0, 3.0]
    assert page.get("/compared", params={"run": [id]}).status_code == 422
    assert page.get("/compared", params={"run": [id, "../x"]}).status_code == 404
    assert len(page.get(f"/runs/{id}/spectra", params={"sample": "K 9"}).json()["spectra"]) == 6
