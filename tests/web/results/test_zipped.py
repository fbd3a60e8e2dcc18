"""The zip of a run's folder is quick to make: its spectra are text, of which there is much."""

import io
import zipfile
import zlib

from labrun.web.results.zipped import LEVEL, zipped


def test_spectra_are_packed_quickly_and_come_out_as_they_were(tmp_path):
    text = "".join(f"{n / 30:.4f},{n * n % 977}\n" for n in range(5000)).encode()
    (tmp_path / "spectrum.csv").write_bytes(text)
    with zipfile.ZipFile(io.BytesIO(b"".join(zipped(tmp_path)))) as archive:
        (info,) = archive.infolist()
        out = archive.read(info)

    assert out == text
    assert info.compress_size == len(zlib.compress(text, LEVEL)) - 6  # without zlib's own frame
