"""Random sequences of calls on two instances of a bundle, with AddressSanitizer, its search for leaks, and
UndefinedBehaviorSanitizer; tests/bench/bundle.py --fuzz makes 100,000.
"""

import re
import shutil

import fmpy
import pytest

from fmus.bundle_fuzz.fuzz_bundle import CHOICE, build_fuzzer, run_fuzzer
from fmus.bundle_host import MS, bundled
from lockstep import Component
from lockstep.fmi.model_description import read_description


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_no_sequence_of_calls_breaks_memory_or_states(cells, tmp_path):
    path = bundled(cells, tmp_path / "four.fmu", CHOICE)
    resources = tmp_path / "unpacked" / "resources"
    fmpy.extract(str(path), str(resources.parent))
    guid = read_description(Component(name="it", source=path, period=MS)).guid
    printed = run_fuzzer(build_fuzzer(tmp_path / "build"), resources, guid, 300)

    accepted, _, ended, refused = map(int, re.findall(r"\d+", printed)[:4])
    assert min(accepted, refused) > 3000
    assert ended > 100
