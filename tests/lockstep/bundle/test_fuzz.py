"""Random sequences of calls on two instances of a bundle, with AddressSanitizer, its search for leaks, and
UndefinedBehaviorSanitizer; tests/bench/bundle.py --fuzz makes 100,000.
"""

import re
import shutil

import fmpy
import pytest

from fmus.bundle_fuzz.fuzz_bundle import CHOICE, as_fmi3, build_fuzzer, run_fuzzer
from fmus.bundle_host import MS, bundled
from lockstep import Component
from lockstep.fmi.model_description import read_description


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
@pytest.mark.parametrize(("version", "inside"), [("2.0", "2.0"), ("3.0", "2.0"), ("2.0", "3.0")])
def test_no_sequence_of_calls_breaks_memory_or_states(cells, tmp_path, version, inside):
    system = cells if inside == "2.0" else as_fmi3(cells, tmp_path)
    path = bundled(system, tmp_path / "four.fmu", CHOICE, version=version)
    resources = tmp_path / "unpacked" / "resources"
    fmpy.extract(str(path), str(resources.parent))
    guid = read_description(Component(name="it", source=path, period=MS)).guid
    printed = run_fuzzer(build_fuzzer(tmp_path / "build", version), resources, guid, 300, version=version)

    accepted, _, ended, refused = map(int, re.findall(r"\d+", printed)[:4])
    assert min(accepted, refused) > 3000
    assert ended > 10
