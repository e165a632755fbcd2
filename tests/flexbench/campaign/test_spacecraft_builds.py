"""Fields of a spacecraft's file as inputs: four wheels, seven modes; built once for each content; what is refused."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

import flexbench.loop.build
from flexbench.campaign.campaign_file import read_campaign
from flexbench.campaign.orders import prepare
from flexbench.campaign.rare.event import check_rare, parse_event
from flexbench.campaign.spacecraft_builds import build_spacecraft
from flexbench.loop.build_options import ONLY_PYTHON
from flexsat.description.spacecraft_file import read_spacecraft
from lockstep import InputError

EXAMPLES = Path(__file__).parents[3] / "examples"
SPACECRAFT = EXAMPLES / "spacecraft" / "four_wheels.toml"
TABLE = "mass,inertia,seed\n700,450,1\n900,450,1\n700,450,2\n"


@pytest.fixture
def campaign_file(tmp_path):
    """Return a function that writes the example, shorter, with cases of a table and with changes."""

    def write(*changes, table=TABLE):
        text = (EXAMPLES / "campaigns/bus_mass.toml").read_text(encoding="utf-8")
        text = text.replace("../spacecraft/four_wheels.toml", str(SPACECRAFT))
        text = text.replace("cases = 8\n", 'table = "cases.csv"\n').replace('"latin-hypercube"', '"table"')
        text = "\n".join(
            line for line in text.splitlines() if line.split(" = ")[0] not in ("distribution", "loc", "scale")
        )
        text = text.replace("stop_time = 5.0", "stop_time = 0.1")
        text = text.replace('[[correlation]]\nof = ["mass", "inertia"]\nvalue = 0.8\n', "")
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "cases.csv").write_text(table)
        (tmp_path / "mass.toml").write_text(text)
        return tmp_path / "mass.toml"

    return write


def test_each_value_is_built_once_and_each_case_has_the_systems_of_its_own(campaign_file, tmp_path, monkeypatch):
    lines, built, real = [], [], flexbench.loop.build.build_files

    def build(files, folder, print_line):  # without the FMUs in C, which take a compiler most of the time
        built.append(files)
        real(files, folder, print_line, ONLY_PYTHON)
        shutil.copytree(folder / "four_wheels", folder / "copy")
        (folder / "copy").rename(folder / "four_wheels" / "native")

    monkeypatch.setattr(flexbench.loop.build, "build_files", build)
    folder = tmp_path / "out"
    (folder / "spacecraft").mkdir(parents=True)
    orders = prepare(read_campaign(campaign_file()), folder, lines.append)

    assert lines[:2] == [f"four_wheels.toml: building its FMUs ({k} of 2)" for k in (1, 2)]
    buses = [one.configurations["robust"].bus for files in built for one in files]
    assert [bus.mass for bus in buses] == [700.0, 900.0]
    assert {(bus.inertia[0], bus.inertia[1]) for bus in buses} == {(450.0, 450.0)}
    assert {bus.inertia[2] for bus in buses} == {600.0}  # as in the file
    kept = [read_spacecraft(path).configurations["robust"] for path in folder.glob("spacecraft/*/four_wheels/*.toml")]
    assert {one.bus.mass for one in kept} == {700.0, 900.0}
    first, second, third = (set(orders.files_of(number)) for number in (1, 2, 3))
    assert first == third
    assert len(first - second) == 4  # the system and its FMUs: the sensors hold what turns into deformation
    assert orders.order(1).overrides["plant.seed"] == 1
    again = prepare(read_campaign(campaign_file()), folder, lines.append)
    assert (len(built), again.files_of(2)) == (2, orders.files_of(2))


@pytest.mark.parametrize(
    ("changes", "table", "message"),
    [
        ([('"bus.mass"', '"bus.weight"')], TABLE, r"case 1 \(mass = 700, inertia = 450\): four_wheels.toml:\d+: bus.w"),
        ([('"bus.mass"', '"bus..mass"')], TABLE, r"input.mass: spacecraft = 'bus..mass': write a key of the file"),
        ([("bus.inertia[1]", "bus.inertia[9]")], TABLE, r"input.inertia: spacecraft = 'bus.inertia\[9\]': \[9\]: the"),
        ([("bus.inertia[1]", "wheels.at")], TABLE, r"at follows a list; write the entry's number, from \[1\]"),
        ([("bus.inertia[1]", "name.long")], TABLE, "name is no table of the file"),
        ([], TABLE.replace("900", "-900"), r"case 2 \(mass = -900, inertia = 450\): four_wheels.toml:\d+: bus.mass"),
        ([(str(SPACECRAFT), "small.ssd")], TABLE, "systems: small.ssd: input.mass changes spacecraft files; give"),
    ],
)  # fmt: skip
def test_what_a_file_refuses_is_said_before_anything_is_built(campaign_file, tmp_path, changes, table, message):
    campaign = read_campaign(campaign_file(*changes, table=table))
    with pytest.raises(InputError, match=message):
        prepare(campaign, tmp_path / "out", lambda _: None)
    assert not (tmp_path / "out").exists()


def test_python_flies_the_fmus_in_python_of_a_spacecraft_file(campaign_file, tmp_path, monkeypatch):
    def build(_files, folder, _print_line):
        for kind in ("", "native"):
            (folder / "four_wheels" / kind).mkdir(parents=True)
            (folder / "four_wheels" / kind / "fine_pointing.ssd").touch()

    monkeypatch.setattr(flexbench.loop.build, "build_files", build)
    fixed = replace(read_campaign(campaign_file()), inputs=())
    for python, kind in ((False, "native"), (True, "four_wheels")):
        campaign = replace(fixed, python=python)
        _, found = build_spacecraft(campaign, [], campaign.systems, tmp_path / "out", lambda _: None)
        assert [path.parent.name for path in found.values()] == [kind]


def test_no_second_choice_of_systems_and_no_chains(campaign_file):
    drawn = ("[systems]\nsmall = ", "[input.which]\nsystem = ")
    with pytest.raises(InputError, match=r"input.mass: changes the spacecraft files under \[systems\]; leave out"):
        read_campaign(campaign_file(drawn))
    chains = campaign_file(('table = "cases.csv"\nsampling = "table"', 'cases = 10\nsampling = "random"'))
    text = chains.read_text()
    for name in ("mass", "inertia", "seed"):
        text = text.replace(f"[input.{name}]", f'[input.{name}]\ndistribution = "case"')
    chains.write_text(text)
    campaign = read_campaign(chains)
    with pytest.raises(InputError, match=r"input.mass: each value of a spacecraft file needs FMUs of its own"):
        check_rare(campaign, parse_event("torque > 1", campaign))
