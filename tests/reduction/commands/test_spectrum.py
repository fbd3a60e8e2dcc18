import numpy as np
import pytest


def write(path, x, y):
    rows = (f"{a:.4f},{b:.2f}" for a, b in zip(x, y, strict=True))
    path.write_text("\n".join(("wavelength,intensity", *rows)))


@pytest.mark.slow
def test_a_spectrum_is_told_in_words_and_figures(tmp_path, labrun, reduced):
    truth, reduction = reduced("train", 0)
    write(tmp_path / "shot.csv", truth.wavelength_nm, truth.intensity)
    done = labrun("spectrum", "shot.csv", "-o", "out", "--log")
    made = {path.name for path in (tmp_path / "out").iterdir()}

    assert done.returncode == 0, done.stderr
    assert f"detected: {reduction.detected[0]}" in done.stdout
    assert {"shot_spectrum.png", "shot_fit.png", "shot_boltzmann.png"} <= made


@pytest.mark.slow
def test_noise_is_drawn_and_claims_nothing(tmp_path, labrun):
    x = np.linspace(300, 700, 3_000)
    write(tmp_path / "noise.csv", x, 100 + np.random.default_rng(2).normal(0, 5, len(x)))
    done = labrun("spectrum", "noise.csv")

    assert done.returncode == 0, done.stderr
    assert "detected: no element" in done.stdout
    assert (tmp_path / "noise_spectrum.png").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing.csv"], "No such file"),
        (["."], "is a folder"),
        (["x.csv"], "the spectrum is empty"),
        (["flat.csv", "--window", "5"], "write it as FROM:TO"),
        (["flat.csv", "--window", "7:5"], "must be smaller"),
        (["flat.csv", "--format", "tif"], "one of png, svg, pdf"),
        (["flat.csv", "--unit", "ly"], "not a unit of wavelength"),
        (["flat.csv", "--elements", "Qq"], "not an element symbol"),
    ],
)
def test_wrong_words_and_files_are_sentences(tmp_path, labrun, words, said):
    (tmp_path / "x.csv").write_text("")
    write(tmp_path / "flat.csv", np.linspace(300, 400, 500), np.full(500, 7.0) + np.arange(500) % 3)
    done = labrun("spectrum", *words)

    assert done.returncode == 2
    assert said in done.stderr and "Traceback" not in done.stderr
