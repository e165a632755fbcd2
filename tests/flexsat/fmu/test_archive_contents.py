"""Files of an FMU other than its code: documentation, licences, pictures, terminals, experiments that replay."""

import hashlib
import html
import os
import subprocess
import sys
import zipfile
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path
from urllib.parse import urlsplit
from xml.etree import ElementTree

import fmpy
import pytest
from lxml import etree
from matplotlib import image

from fmus.toys.builds import python
from lockstep.fmi.description_corrections import validation_problems

COMPONENTS = ("plant", "sensors", "controller")
FOLDERS = ("centralised", "distributed", "centralised/flat", "distributed/flat")
TWELVE = [f"{folder}/{component}" for folder in FOLDERS for component in COMPONENTS]
LAYER = "extra/org.fmi-standard.fmi-ls-ref"
SCHEMAS = Path(fmpy.__file__).parent / "schema"
MEGABYTE = 1_000_000


@pytest.fixture(params=TWELVE)
def fmu(request, delivered):
    """Return each of the twelve in turn."""
    return delivered / f"{request.param}.fmu"


def contents(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


class Links(HTMLParser):
    """Collect what a page refers to."""

    def __init__(self, page):
        super().__init__()
        self.targets, self.ids = [], set()
        self.feed(page)

    def handle_starttag(self, _tag, attributes):
        for name, value in attributes:
            if name in ("href", "src"):
                self.targets.append(value)
            if name == "id":
                self.ids.add(value)


def test_fmpy_and_the_schemas_find_no_problem(fmu):
    files = contents(fmu)
    description = etree.XMLSchema(etree.parse(str(SCHEMAS / "fmi2" / "fmi2ModelDescription.xsd")))
    terminals = etree.XMLSchema(etree.parse(str(SCHEMAS / "fmi3" / "fmi3TerminalsAndIcons.xsd")))

    assert validation_problems(fmu) == []
    description.assertValid(etree.fromstring(files["modelDescription.xml"]))
    terminals.assertValid(etree.fromstring(files["terminalsAndIcons/terminalsAndIcons.xml"]))


def test_every_link_of_the_page_leads_to_a_file_in_the_archive(fmu):
    files = contents(fmu)
    links = Links(files["documentation/index.html"].decode())

    assert links.targets
    for target in links.targets:
        parts = urlsplit(target)
        assert not parts.scheme, target
        assert not parts.netloc, target
        if parts.path:
            assert os.path.normpath(f"documentation/{parts.path}") in files, target
        else:
            assert parts.fragment in links.ids


def test_the_page_shows_every_port_as_the_model_description_has_it(fmu):
    files = contents(fmu)
    page = "".join(ElementTree.fromstring(files["documentation/index.html"].partition(b"\n")[2]).itertext())
    description = fmpy.read_model_description(str(fmu))

    for variable in description.modelVariables:
        last = variable.name.rstrip("]0123456789")
        assert last in page, variable.name
    assert description.modelName in page


def test_the_pictures_open_and_are_small(fmu):
    files = contents(fmu)

    assert image.imread(BytesIO(files["model.png"])).shape[:2] == (480, 480)
    assert image.imread(BytesIO(files["terminalsAndIcons/icon.png"])).shape[:2] == (128, 128)
    assert len(files["model.png"]) < MEGABYTE / 5


def test_licences_and_dependencies_are_there(fmu):
    files = contents(fmu)
    entry = files["documentation/licenses/license.txt"].decode()
    texts = [name for name in files if name.startswith("documentation/licenses/") and not name.endswith("license.txt")]

    assert len(texts) == 2
    for name in texts:
        assert Path(name).name in entry
    both = b"".join(files[name] for name in texts)
    assert f'simulate_fmu("{fmu.name}", ' in html.unescape(files["documentation/index.html"].decode())
    assert b"BSD 3-Clause License" in both
    assert b"MIT License" in both
    needs = files["documentation/externalDependencies.txt"].decode()
    for word in ("libpython3.11.so.1.0", "LD_PRELOAD", "RTLD_GLOBAL", "numpy", "PYTHONPATH", "python3.dll"):
        assert word in needs, word


def test_the_manifest_of_the_experiments_is_true_and_small(fmu):
    files = contents(fmu)
    root = ElementTree.fromstring(files[f"{LAYER}/fmi-ls-manifest.xml"])
    listed = {}
    for related in root.findall("Related"):
        path = os.path.normpath(f"{LAYER}/{related.get('source')}")
        listed[path] = related
        if related.get("checksum"):
            assert hashlib.sha3_256(files[path]).hexdigest() == related.get("checksum")

    inside = {name for name in files if name.startswith(LAYER)} - {f"{LAYER}/fmi-ls-manifest.xml"}
    assert inside <= set(listed)
    assert set(listed) - inside == {"documentation/fmi-ls-ref.txt"}
    with zipfile.ZipFile(fmu) as archive:
        assert sum(archive.getinfo(name).compress_size for name in inside) < MEGABYTE


SIMULATE = """
import io
import numpy as np
from fmpy import simulate_fmu
from replay import *
from session import argument
path = argument(0)
archive = Archive(path)
for experiment in archive.experiments():
    names, references = archive.series(experiment, "References")
    inputs, stimuli = archive.series(experiment, "Stimuli")
    kinds = [(n, float) for n in ("time", *inputs)]
    columns = np.array([tuple(row) for row in stimuli], dtype=kinds) if stimuli else None
    step = float(experiment.get("stepSize"))
    result = simulate_fmu(
        path, stop_time=float(experiment.get("stopTime")), step_size=step, output_interval=step, output=names,
        start_values=archive.parameters(experiment), input=columns,
    )
    references = np.array(references)
    rows = np.searchsorted(result["time"], references[:, 0] - 0.5 * step)
    assert np.allclose(result["time"][rows], references[:, 0], atol=1e-9)
    port = {}
    for k, name in enumerate(names, start=1):
        port.setdefault(name.partition("[")[0].rstrip("0123456789"), []).append((name, k))
    for members in port.values():
        found = np.array([result[name][rows] for name, _ in members], dtype=float)
        wanted = np.array([references[:, k] for _, k in members])
        # FMPy interpolates between rows whose times differ from its own in the last digit
        assert np.abs(found - wanted).max() <= 1e-9 * np.abs(wanted).max() + 1e-300, members[0][0]
"""


@pytest.mark.parametrize("name", TWELVE[:6])
def test_a_host_that_simulates_from_the_files_gets_the_same(delivered, name):
    python(SIMULATE, delivered / f"{name}.fmu")


def test_another_order_of_summation_stays_within_the_stated_tolerance(delivered, monkeypatch):
    """Other kernels of OpenBLAS add in another order, as on a receiver's other processor."""
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Prescott")
    script = "from replay import check_experiments; [check_experiments(path, 1e-9) for path in sys.argv[1:]]"
    python(script, *(delivered / "centralised" / f"{component}.fmu" for component in COMPONENTS))


LOGGING = """
import ctypes
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from session import argument
description = read_model_description(argument(0))
folder = extract(argument(0))
declared = [category.name for category in description.logCategories]

def heard(on, categories, instantiated=False):
    messages = []
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(
        lambda _, name, status, category, text: messages.append((name, status, category))
    )
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName="one",
                    modelIdentifier=description.coSimulation.modelIdentifier)
    fmu.instantiate(callbacks=callbacks, loggingOn=instantiated)
    if categories is not None:
        listed = (ctypes.c_char_p * len(categories))(*(name.encode() for name in categories))
        status = fmu.fmi2SetDebugLogging(fmu.component, on, len(categories), listed)
        assert status == (0 if set(categories) <= set(declared) else 1), status  # fmi2Warning
    fmu.setupExperiment(); fmu.enterInitializationMode(); fmu.exitInitializationMode()
    try:
        fmu.doStep(0.0, -1.0)
    except Exception as error:
        assert error.status == 3, error.status
    else:
        raise AssertionError("a step backwards was accepted")
    fmu.freeInstance()
    return messages

error = [(b"one", 3, b"logStatusError")]
assert declared == ["logStatusError"], declared
# an error is logged whatever was switched on: it is no debug message
for on in (True, False):
    assert heard(on, declared) == heard(on, []) == heard(None, None, instantiated=on) == error
    assert heard(on, ["logStatusWarning"]) == [(b"one", 1, b"logStatusError"), *error]  # no such category: a warning
assert heard(False, [], instantiated=True) == error
"""


@pytest.mark.parametrize("component", COMPONENTS)
def test_the_log_categories_do_what_the_model_description_says(delivered, component):
    python(LOGGING, delivered / "centralised" / f"{component}.fmu")


def test_neither_the_wrapper_nor_our_package_needs_to_be_installed(delivered, tmp_path):
    """The text says that numpy is all: here is a Python that has numpy and FMPy, and neither of them."""
    packages = Path(fmpy.__file__).parents[1]
    for entry in packages.iterdir():
        if not entry.name.lower().startswith(("pythonfmu", "flexsat", "_flexsat", "lockstep", "flexbench")):
            (tmp_path / entry.name).symlink_to(entry)
    script = """
import importlib.util, sys
assert importlib.util.find_spec("pythonfmu") is None and importlib.util.find_spec("flexsat") is None
from fmpy import simulate_fmu
result = simulate_fmu(sys.argv[1], stop_time=0.05, output=["energy"])
assert result["energy"][-1] > 0.0
assert "/resources/" in sys.modules["pythonfmu"].__file__
"""
    subprocess.run(
        [sys.executable, "-S", "-c", script, delivered / "centralised" / "plant.fmu"],
        check=True,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
    )
