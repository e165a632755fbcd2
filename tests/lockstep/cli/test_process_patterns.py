"""Names and patterns of --isolate, --share-process and --step-size."""

from pathlib import Path

import pytest

from lockstep.cli.run_options import with_processes
from lockstep.cli.timing_options import with_step_sizes
from lockstep.errors import InputError
from lockstep.ssp.step_times import Timing
from lockstep.system.component import Component
from lockstep.system.system import System

SYSTEM = System(
    name="grid",
    tick=1,
    components=tuple(
        Component(name=name, source=Path("none.fmu"), period=1) for name in ("gen1", "gen2", "load", "a/b")
    ),
)


@pytest.mark.parametrize(("isolated", "shared", "expected"), [
    (["gen*"], [], [True, True, None, None]),
    (["*"], [], [True, True, True, True]),
    (["gen?", "a*"], ["load"], [True, True, False, True]),
    (["gen2"], ["gen*"], [False, True, None, None]),
    (["gen*"], ["gen2"], [True, False, None, None]),
    ([], ["*"], [False, False, False, False]),
])  # fmt: skip
def test_name_goes_before_a_pattern(isolated, shared, expected):
    found = with_processes(SYSTEM, isolated, shared)
    assert [component.isolated for component in found.components] == expected


@pytest.mark.parametrize(("isolated", "shared", "message"), [
    (["gem*"], [], "--isolate gem*: no such component; there are gen1, gen2, load, a/b"),
    ([], ["gen3"], "--share-process gen3: no such component; there are gen1, gen2, load, a/b"),
    (["gen*"], ["*1"], "--share-process *1: --isolate gen* names gen1 too; choose one"),
    (["load"], ["load"], "--share-process load: --isolate load names load too; choose one"),
    (["gen[1]"], [], "--isolate gen[1]: no such component"),
])  # fmt: skip
def test_what_names_nothing_or_contradicts_is_refused(isolated, shared, message):
    with pytest.raises(InputError) as refused:
        with_processes(SYSTEM, isolated, shared)
    assert str(refused.value).startswith(message)


def test_step_sizes_are_those_of_the_name_else_of_the_pattern_else_of_all():
    found = with_step_sizes(SYSTEM, ["gen2=0.004", "gen*=0.002", "0.001"])
    assert [component.period for component in found.components] == [2_000_000, 4_000_000, 1_000_000, 1_000_000]
    timing = Timing(period=1, periods={"gen*": 2, "gen2": 4})
    assert [timing.given_period(component.name) for component in SYSTEM.components] == [2, 4, 1, 1]
    timing.check_names(SYSTEM)


def test_step_size_for_no_component_or_by_two_patterns_is_refused():
    with pytest.raises(InputError, match=r"gem\*: no such component; there are gen1, gen2, load, a/b"):
        Timing(periods={"gem*": 2}).check_names(SYSTEM)
    with pytest.raises(InputError, match=r"gen1: --step-size is given by gen\* and by \*1; give it for gen1 itself"):
        Timing(periods={"gen*": 2, "*1": 4}).given_period("gen1")
