"""From the page: spectra of a finished run become plasma, areas and classes of its points."""

import struct

import pytest

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def measured(shared):
    """A server with a finished run of six points of its own: what is reduced stays in its folder."""
    client = shared.client().reach("gantry", "libs")
    client.take("Ada", reason="a run to reduce")
    run = client.run_of("grid.yaml")
    client.until(run, "succeeded")
    yield shared, client, run
    client.post("/control/release", headers=client._leased())


@pytest.mark.soak
def test_a_run_is_reduced_to_maps_of_its_points_that_can_be_downloaded(measured, wait_for, socket):
    house, client, run = measured
    page = socket(house, client)
    before = client.get(f"/runs/{run}/reduction").json()
    asked = client.post(f"/runs/{run}/reduce")
    again = client.post(f"/runs/{run}/reduce")
    wait_for(lambda: client.get(f"/runs/{run}/reduction").json()["state"] == "done", "maps", 500)
    told = client.get(f"/runs/{run}/reduction").json()
    tables = {table["name"]: table for table in client.get(f"/runs/{run}/tables").json()}
    maps = client.get(f"/runs/{run}/maps").json()
    plasma = client.get(f"/runs/{run}/tables/reduced/plasma.csv").json()["columns"]
    areas = client.get(f"/runs/{run}/tables/maps/maps.csv").json()["columns"]
    warm = client.get(f"/runs/{run}/maps/reduced/plasma.csv/temperature_k")
    wait_for(lambda: [one for one in page.all("notice") if one["run"] == run], "a notice")
    download = f"/runs/{run}/tables/reduced/plasma.csv/download"
    text, packed = client.get(download), client.get(download, params={"format": "parquet"})
    unknown = client.get(f"/runs/{run}/tables/reduced/elements.csv")

    assert before == {"state": "none", "text": "", "tables": []}
    assert asked.status_code == again.status_code == 202
    assert again.json()["state"] in ("waiting", "working")
    assert {"reduced/plasma.csv", "maps/maps.csv"} <= set(told["tables"]) <= set(tables)
    assert "made" not in told["text"] and str(house.folder) not in told["text"]
    assert plasma["key"] == ["0,0", "0,1", "1,0", "1,1", "2,0", "2,1"]
    assert plasma["x_mm"] == [0, 0, 1, 1, 2, 2] and plasma["spectrum"][1] == "spectra/0_1.csv"
    assert sorted(areas["key"]) == sorted(plasma["key"]) and "Si" in areas
    assert maps["cell_keys"]["reduced/plasma.csv"] == maps["cell_keys"]["data.csv"]
    cells = struct.unpack("<6f", warm.content)
    assert cells[1] == pytest.approx(plasma["temperature_k"][plasma["key"].index("1,0")], rel=1e-6)
    notice = next(one for one in page.all("notice") if one["run"] == run)
    assert (notice["run"], notice["level"]) == (run, "info")
    assert text.text.splitlines()[0].startswith("key,x_mm,y_mm,spectrum,temperature_k")
    assert f"{run}_reduced_plasma.csv" in text.headers["content-disposition"]
    assert packed.content[:4] == b"PAR1" and unknown.status_code == 404


def test_a_run_without_spectra_says_why_it_is_not_reduced(measured, wait_for):
    _, client, _ = measured
    asking = client.run_of("talk.yaml")  # alive as long as nobody answers
    live = client.post(f"/runs/{asking}/reduce")
    client.command(f"/runs/{asking}/abort")
    client.until(asking, "aborted")
    run = client.run_of("long.yaml")
    client.until(run, "succeeded")
    client.post(f"/runs/{run}/reduce")
    wait_for(lambda: client.get(f"/runs/{run}/reduction").json()["state"] == "failed", "a reason")
    told = client.get(f"/runs/{run}/reduction").json()

    assert (live.status_code, live.json()["code"]) == (409, "LIVE")
    assert "spectr" in told["text"] and "Traceback" not in told["text"]
    assert client.post("/runs/none/reduce").status_code == 404
