"""Fuzzed calls and states of native components: no crash, no leak, no refused call that returns OK.

libFuzzer with AddressSanitizer and UndefinedBehaviorSanitizer, always with the same inputs; tests/bench/fuzz_native.py
makes 100,000.
"""

import pytest

from fmus.native.fuzz_targets import TARGETS, build_targets, fuzzer_is_missing, run_target, sources_of

RUNS = {("toy", "sequences"): 2000, ("toy", "states"): 4000, ("controller", "sequences"): 250,
        ("controller", "states"): 400}  # fmt: skip


@pytest.fixture(scope="module", params=["toy", "controller"])
def targets(request, tmp_path_factory):
    if fuzzer_is_missing():
        pytest.skip(fuzzer_is_missing())
    component = request.param
    return component, build_targets(component, sources_of(component), tmp_path_factory.mktemp(component))


@pytest.mark.parametrize("target", TARGETS)
def test_no_input_makes_a_component_answer_wrongly(targets, target):
    component, programs = targets
    runs = RUNS[component, target]

    calls = run_target(programs[target], runs)

    assert calls["ok"] > runs  # many calls are legal,
    assert calls["refused"] > runs / 4  # many are not,
    assert calls["steps"] > runs / 2  # and runs go on
