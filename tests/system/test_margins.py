"""Margins through FMUs: a known loop in C, our LQG against its analysis, and the delay that really destabilises it.

Our LQG is measured with native FMUs, as the command does; `flexbench/studies/test_fmus_of_sweeps.py` measures it with
those in Python too.
"""

import json
import sys
from pathlib import Path

import control
import numpy as np
import pytest
from numpy.testing import assert_allclose

from flexbench.studies.margins.analysis import AXES, body_loops
from flexbench.studies.margins.response import loop_margins
from flexbench.studies.margins.stability import delay_margin
from flexbench.studies.margins.system_loop import read_loop
from flexsat.description.built_in import CONFIGURATIONS
from lockstep import load_system

sys.path.append(str(Path(__file__).parent))
from known_loop.known_loop import STEP, build_known_loop, known_response

PUBLISHED = {"controller.design": "published", "plant.modes": 25}

# One measurement: the loop, and the margins with their uncertainties
MEASURE = """
from flexbench.studies.margins.system_loop import read_loop
from flexbench.studies.margins.study import MeasurementSettings, measure
from flexbench.loop.fmu_choice import choose_fmus
from lockstep import load_system
system, folder, options = given
system = load_system(Path(system))
loop = read_loop(choose_fmus([system]).of(system), options.get("overrides", {}))
found, margins = measure(loop, MeasurementSettings(**options), Path(folder))
result = {"frequency": found.frequency.tolist(), "margins": margins, "names": list(found.names),
        "period": found.period, "coherence": found.coherence.T.tolist(),
        "coherent": [found.of(name)[1].tolist() for name in (*found.names, "together")]}
for name in ("single", "together"):
    values = getattr(found, name)
    result[name] = [values.real.tolist(), values.imag.tolist()]
    result[f"{name}_uncertainty"] = getattr(found, f"{name}_uncertainty").tolist()
"""

DELAY = """
from flexbench.studies.margins.system_loop import read_loop
from flexbench.studies.margins.unstable_delay import destabilising_delay
from dataclasses import asdict
from flexbench.loop.native_fmus import with_native_fmus
from lockstep import load_system
system, folder, between, overrides = given
loop = read_loop(with_native_fmus(load_system(Path(system))), overrides)
result = asdict(destabilising_delay(loop, Path(folder), tuple(between), overrides=overrides))
"""


def response(result, name):
    real, imaginary = result[name]
    return np.array(real) + 1j * np.array(imaginary)


# A small loop in C


@pytest.fixture(scope="module")
def known_system(tmp_path_factory):
    """Return the system file of the known loop, beside its FMUs."""
    return build_known_loop(tmp_path_factory.mktemp("known"))


@pytest.fixture(scope="module")
def known(python, known_system, tmp_path_factory):
    """Return what was measured of the known loop, whose sensor is noisy."""
    folder = tmp_path_factory.mktemp("known-runs")
    options = {"length": 10.0, "settle": 1, "periods": 12, "lines": 40, "amplitude": 1.0}
    return python(MEASURE, known_system, folder / "runs", options | {"overrides": {"plant.noise": 0.02}})


def test_the_known_loop_is_recovered_to_two_per_cent_where_coherent(known):
    frequency, coherent = np.array(known["frequency"]), np.array(known["coherent"][0])
    expected = known_response(frequency)
    error = np.abs(response(known, "single")[:, 0] - expected) / np.abs(expected)
    assert 15 < coherent.sum() < len(frequency)  # the noise leaves some lines out
    assert error[coherent].max() < 0.02
    assert error[~coherent].max() > error[coherent].max()


def test_the_known_loop_lies_within_the_stated_uncertainty(known):
    off = np.abs(response(known, "single")[:, 0] - known_response(np.array(known["frequency"])))
    inside = off <= np.array(known["single_uncertainty"])[:, 0]
    # 95 % intervals, for a modulus (two dimensions) a little less: of 40 lines 32 at least, but for once in 1000
    assert inside.sum() >= 32


def test_margins_of_the_known_loop_are_those_of_python_control(known):
    frequency = np.geomspace(0.1, 49.0, 4000)
    reference = control.FrequencyResponseData(known_response(frequency), 2.0 * np.pi * frequency, smooth=True)
    gain, phase, _, _, _, _ = control.stability_margins(reference)
    margins = known["margins"]["input"]
    value, uncertainty = margins["value"], margins["uncertainty"]
    for name, expected in (("gain_up", gain), ("phase", phase)):
        assert value[name] == pytest.approx(expected, rel=0.02)
        assert uncertainty[name] < 0.1 * expected
    exact = loop_margins(frequency, known_response(frequency), STEP)
    assert value["delay"] == pytest.approx(exact.delay, rel=0.02)
    assert value["disk"] == pytest.approx(exact.disk, rel=0.02)
    json.dumps(margins)  # every number is one that JSON knows


# Our LQG


def published(fmus, name):
    """Return the published design's loop on a plant of the modes that it knows, which is near its margins."""
    return read_loop(load_system(fmus / name / "fine_pointing.ssd"), PUBLISHED).designed


def compare(result, loop, noisy):
    """Check a measurement of one of our loops against the analysis at the same lines."""
    share, makes = loop.body_axes
    frequency = np.array(result["frequency"])
    together, single = body_loops(loop.at().complementary_sensitivity(frequency, share), makes)
    coherent = np.array(result["coherent"])
    kept = coherent[:3].T
    off = np.abs(response(result, "single") - single)
    assert kept.sum() > (20 if noisy else 30)
    inside = (off <= np.array(result["single_uncertainty"]))[kept]
    assert inside.mean() > (0.9 if noisy else 0.97)
    inside = (np.abs(response(result, "together") - together) <= np.array(result["together_uncertainty"]))[coherent[3]]
    assert inside.mean() > (0.9 if noisy else 0.97)
    if not noisy:  # and much nearer where no mode rings on: against the distance to -1
        quick = frequency > 12.0
        assert_allclose(response(result, "single")[quick], single[quick], atol=1e-3)
    for k, which in enumerate((*AXES, "together")):
        keep = coherent[k]
        lines = (together if which == "together" else single[:, k])[keep]
        margins = result["margins"][which]
        if "problem" in margins:
            assert keep.sum() < 2
            continue
        expected = loop_margins(frequency[keep], lines, result["period"])
        for kind in ("gain_up", "phase", "delay", "disk"):
            found = margins["value"][kind]
            if found is None:
                assert not np.isfinite(getattr(expected, kind))
            else:
                assert found == pytest.approx(getattr(expected, kind), abs=2.0 * margins["uncertainty"][kind])
    return result["margins"]


def test_the_measured_margins_are_the_designs_without_noise(python, fmus, tmp_path):
    options = {"length": 5.0, "settle": 1, "periods": 3, "quiet": True, "overrides": PUBLISHED}
    result = python(MEASURE, fmus / "centralised" / "fine_pointing.ssd", tmp_path / "runs", options)
    margins = compare(result, published(fmus, "centralised"), noisy=False)
    # between lines a third of an octave apart; the exact one is 3.78 ms
    assert margins["together"]["value"]["delay"] == pytest.approx(3.78e-3, abs=0.1e-3)


@pytest.mark.slow
def test_the_measured_margins_are_the_designs_with_noise_and_jitter(python, fmus, tmp_path):
    overrides = {**PUBLISHED, "plant.seed": 1, "sensors.seed": 1}
    options = {"length": 10.0, "settle": 1, "periods": 5, "overrides": overrides}
    result = python(MEASURE, fmus / "distributed" / "fine_pointing.ssd", tmp_path / "runs", options, timeout=600)
    compare(result, published(fmus, "distributed"), noisy=True)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "between"), [("centralised", (0.0035, 0.0041)), ("distributed", (0.0049, 0.0051))])
def test_the_delay_that_destabilises_the_co_simulation_is_the_analysed_one(python, fmus, tmp_path, name, between):
    assert name in CONFIGURATIONS
    result = python(DELAY, fmus / name / "fine_pointing.ssd", tmp_path / "runs", between, PUBLISHED, timeout=900)
    analysed = delay_margin(published(fmus, name).at)
    assert result["stable"] < analysed < result["unstable"]  # 0.1 ms apart
    assert result["unstable"] - result["stable"] == pytest.approx(1e-4)
    # where the growth rate passes zero; the plant's step of 0.1 ms and the windows leave little
    assert result["delay"] == pytest.approx(analysed, abs=5e-6)


# The command


def test_the_command_measures_a_vendors_controller(flexsat, known_system, tmp_path):
    vendor, out = tmp_path / "vendor.fmu", tmp_path / "out"
    vendor.write_bytes((known_system.parent / "controller.fmu").read_bytes())
    done = flexsat("margins", known_system, "--replace", f"controller={vendor}", "--amplitude", 1, "--length", 5,
                   "--settle", 1, "--periods", 2, "--lines", 30, "--set", "plant.noise=0.001",
                   "--out", out)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "measured: input" in done.stdout
    content = json.loads((out / "margins.json").read_text())
    assert content["controller"] == str(vendor)
    assert "analysis" not in content
    assert content["measured"]["margins"]["input"]["value"]["gain_up"] > 1.0
    assert sorted(path.name for path in (out / "figures").iterdir()) == [
        "coherence.png", "coherence.svg", "nichols.png", "nichols.svg",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "--amplitude: not known for this plant"),
        (("--amplitude", 1, "--controller", "nobody"), "nobody: no such component; there are controller, plant"),
        (("--gains", 3), "--modes, --gains: have no effect: controller is not a controller of flexsat, and the table"),
        (("--analytic-only",), "controller: not a controller of flexsat"),
        (("--analytic-only", "--set", "plant.nois=1"), "plant.nois: no such parameter; plant has"),
    ],
)
def test_bad_input_gets_one_line(flexsat, known_system, tmp_path, options, message):
    done = flexsat("margins", known_system, *options, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert message in done.stderr.splitlines()[-1]
    assert "Traceback" not in done.stderr
