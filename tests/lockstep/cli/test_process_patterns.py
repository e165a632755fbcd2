"""Names and patterns of --isolate and --share-process."""

from pathlib import Path

import pytest

from lockstep.cli.run_options import with_processes
from lockstep.errors import InputError
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
