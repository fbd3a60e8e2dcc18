"""The built page as files: one page for every place, packed where the browser takes it."""

import gzip

import httpx
import pytest

from labrun.web.server.pages import Pages


@pytest.fixture
def built(tmp_path):
    """A page as vite leaves it."""
    folder = tmp_path / "app-dist"
    (folder / "assets").mkdir(parents=True)
    (folder / "index.html").write_text("<!doctype html><title>labrun</title>")
    (folder / "assets" / "main-1a2b.js").write_text("export {}")
    (folder / "assets" / "main-1a2b.js.gz").write_bytes(gzip.compress(b"export {}"))
    (tmp_path / "secret.txt").write_text("secret")
    return folder


def get(folder, path, **headers):
    import asyncio

    async def ask():
        transport = httpx.ASGITransport(Pages(folder))
        async with httpx.AsyncClient(transport=transport, base_url="http://labrun") as client:
            return await client.get(path, headers=headers)

    return asyncio.run(ask())


def test_files_with_a_hash_are_kept_for_ever_and_the_page_is_asked_for_anew(built):
    page, script = get(built, "/"), get(built, "/assets/main-1a2b.js")

    assert page.headers["cache-control"] == "no-cache"
    assert "immutable" in script.headers["cache-control"]
    assert script.headers["content-type"].startswith("text/javascript")


def test_the_page_answers_for_each_of_its_own_places_but_not_for_missing_files(built):
    deep = [get(built, path) for path in ("/runs/42", "/protocols/scan.yaml", "/protocols/a/b.yml")]
    missing = [get(built, path) for path in ("/assets/gone.js", "/favicon.ico", "/assets/a/b")]

    assert all("labrun" in answer.text for answer in deep)
    assert [answer.status_code for answer in missing] == [404] * 3


def test_packed_files_are_sent_to_those_who_take_them(built):
    packed = get(built, "/assets/main-1a2b.js", **{"Accept-Encoding": "br, gzip"})
    plain = get(built, "/assets/main-1a2b.js", **{"Accept-Encoding": "gzip;q=0"})

    assert packed.headers["content-encoding"] == "gzip" and packed.text == "export {}"
    assert "content-encoding" not in plain.headers and plain.text == "export {}"


@pytest.mark.parametrize(
    "path", ["/../secret.txt", "/..%2fsecret.txt", "/assets/%2e%2e/%2e%2e/secret.txt"]
)
def test_no_address_leads_out_of_the_folder(built, path):
    assert "secret" not in get(built, path).text


def test_without_a_built_page_it_is_said_how_to_build_it(tmp_path):
    answer = get(tmp_path, "/runs")

    assert answer.status_code == 503 and "npm ci" in answer.text
