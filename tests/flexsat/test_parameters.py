"""Every parameter reaches what is built: each field of each class is changed in turn, and the change is found."""

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cache

import numpy as np
import pytest

from flexbench.loop.scenarios import scenario_parameters
from flexsat.closed_loop import PORTS
from flexsat.description.built_in import configuration
from flexsat.description.configuration import Configuration, Release
from flexsat.description.placement import Bus, Device, Site, direction
from flexsat.design.chain import as_arrays, build_design, designs_of
from flexsat.fmu.build import component_resources
from flexsat.parameters import (
    MESH_KINDS,
    MODE_CHOICES,
    SUPPORTS,
    Modes,
    Rates,
    SensorErrors,
    SensorNoise,
    Slew,
    SpeedSelection,
    Wheel,
)
from flexsat.ports import controller, declared, plant, sensor_errors, sensors
from flexsat.ports.units import UNITS
from flexsat.quantities import Range, quantity
from flexsat.variants import AS_PUBLISHED, CORRECTED, Variant

# few speeds, modes and gains in a period, as they take most of a design's time
STOCK = replace(
    configuration("centralised"),
    bus=Bus(mass=100.0, inertia=(60.0, 80.0, 100.0, 2.0, -4.0, 6.0), centre_of_mass=(0.2, -0.1, -1.5)),
    modes=Modes(plant=14, design=8),
    wheel=replace(configuration("centralised").wheel, speed_limit=600.0, full_torque_speed=100.0),
    speeds=SpeedSelection(points=150),
    rates=Rates(star_tracker=0.02),
)
OF_RECORD = (("aperture", "tile_side"), ("aperture", "rings"))
# their own tests change these: files of structures, a table of harmonics, meshes other than that of record, and what
# has an effect where speeds avoid crossings alone
NOT_HERE = (
    ("speeds", "clearance"),
    ("speeds", "crossing_response"),
    ("appendages",),
    ("wheel", "harmonics"),
    ("aperture", "mesh"),
    ("aperture", "refinements"),
    ("aperture", "support"),
)
CHOICES = ("design_by", "mesh", "support", "gyroscopic", "avoid_crossings")
WORDS = (("name",), ("layout",))  # in names of files and models, and in documentation
FACTORS = (1.05, 1.3, 2.0, 0.5)  # a choice among discrete speeds may survive a small change


def paths(parameters: object, prefix: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield the path of each field that is a value, through nested parameter classes."""
    for item in fields(parameters):
        inner = getattr(parameters, item.name)
        path = (*prefix, item.name)
        if is_dataclass(inner):
            yield from paths(inner, path)
        else:
            yield path


def changed(value: object, factor: float) -> object:
    """Return another value of the same kind."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        choices = next(known for known in (MODE_CHOICES, MESH_KINDS, SUPPORTS) if value in known)
        return next(name for name in choices if name != value)
    if isinstance(value, Site):
        return replace(value, radius=14.176, angle=120.0)
    if isinstance(value, Device):
        x, y, z = value.axis
        return replace(value, axis=direction((x + 0.01, y + 0.02, z)))
    if value == 0:  # off: on, any weight, or an error within its range
        return 1e6 if factor == FACTORS[0] else 1e-6
    if isinstance(value, int):
        return value + 1 if factor > 1.0 else value - 1
    if isinstance(value, tuple) and isinstance(value[0], str):  # an order of names
        return (value[1], value[0], *value[2:])
    if isinstance(value, tuple):
        return (changed(value[0], factor), *value[1:])
    assert isinstance(value, float)
    return factor * value


def with_value(parameters: object, path: tuple[str, ...], value: object) -> object:
    """Return parameters with the field at a path replaced."""
    name, *rest = path
    return replace(parameters, **{name: with_value(getattr(parameters, name), tuple(rest), value) if rest else value})


def value_at(parameters: object, path: tuple[str, ...]) -> object:
    """Return the field at a path."""
    for name in path:
        parameters = getattr(parameters, name)
    return parameters


@cache
def built(config: Configuration, variant: Variant) -> dict[str, object]:
    """Return everything that is built from parameters: arrays of the FMUs, ports, and what the slew scenario sets."""
    design = designs_of(config, config).variant(variant)
    found: dict[str, object] = {}
    for component, ports in PORTS.items():
        matrices = getattr(design, component)
        found |= as_arrays(matrices, component)
        found |= {f"{component} port {port.name}": port.starts for port in ports(matrices)}
    commanded = scenario_parameters("slew", slew=config.slew)
    return found | {
        f"{component} starts with {port}": value
        for component, values in commanded.items()
        for port, value in values.items()
    }


def differing(one: dict[str, object], other: dict[str, object]) -> set[str]:
    """Return the names of what differs."""
    return {name for name in one.keys() | other.keys() if not np.array_equal(one.get(name), other.get(name))}


@pytest.mark.parametrize("path", [path for path in paths(STOCK) if path not in (*WORDS, *NOT_HERE)], ids=".".join)
def test_a_changed_parameter_changes_what_is_built(path):
    variant = AS_PUBLISHED if path[0] == "release" else CORRECTED
    stock = STOCK
    found, refusals = set(), []
    for factor in FACTORS:
        try:
            other = with_value(stock, path, changed(value_at(stock, path), factor))
            found = differing(built(stock, variant), built(other, variant))
        except ValueError as error:
            refusals.append(str(error))
        if found:
            break

    if path in OF_RECORD:  # the interior nodes of the mesh of record are placed for one aperture
        assert all('"record" is made for tiles of 2.0 m in 4 rings' in text for text in refusals)
        assert len(refusals) == len(FACTORS)
    else:
        assert found, refusals


def test_ports_start_with_the_changed_parameters(monkeypatch):
    """Ports that show a parameter start with its value, in its unit and range."""
    shown = {}

    def noted(owner, field, **rest):
        port = declared.parameter_port(owner, field, **rest)
        shown[owner, field, port.name] = port
        return port

    for module in (plant, sensors, sensor_errors, controller):
        monkeypatch.setattr(module, "parameter_port", noted)
    values, classes = {}, {}
    for item in fields(STOCK):
        given = getattr(STOCK, item.name)
        if type(given) in (Rates, Slew, Wheel, SensorNoise, SensorErrors):
            # whole multiples of each other stay so
            factor = 2.0 if type(given) is Rates else 0.9
            new = {one.name: elementwise(getattr(given, one.name), factor) for one in fields(given)
                   if (item.name, one.name) not in NOT_HERE}  # fmt: skip
            values |= {(type(given), name): value for name, value in new.items()}
            classes[item.name] = replace(given, **new)
    design = build_design(replace(STOCK, **classes))
    for component, ports in PORTS.items():
        ports(getattr(design, component))

    assert {owner for owner, _, _ in shown} == {type(one) for one in classes.values()}
    for (owner, field, name), port in shown.items():
        known = quantity(owner, field)
        first = name == "step_size"  # 0 is that of the first step; the period is the step that the FMU recommends
        least = 0.0 if first else known.range.least
        assert (port.unit, port.minimum, port.maximum) == (known.unit, least, known.range.most), name
        if name != "command.rotation":  # commanded by a scenario; no slew unless it is
            value = values[owner, field]
            expected = [0.0] if first else value if isinstance(value, tuple) else [value]  # one for all wheels
            assert np.ravel(port.start).tolist() == pytest.approx(np.resize(expected, np.size(port.start)), rel=1e-15)


def elementwise(value, factor):
    """Return another value, of a tuple in every element."""
    return tuple(changed(one, factor) for one in value) if isinstance(value, tuple) else changed(value, factor)


def test_both_variants_travel_with_the_changed_parameters():
    config = replace(STOCK, rates=Rates(star_tracker=0.2), slew=Slew(authority=0.4, start_time=7.0))
    designs = designs_of(config, config)
    for design in (designs.corrected, designs.variant(AS_PUBLISHED)):
        assert design.controller.gain_coarse.shape[0] == design.controller.gain_fine.shape[0] == 40
        assert (design.controller.authority, design.controller.slew_start) == (0.4, 7.0)
        assert design.sensors.star_tracker_period == 0.2
    stock = designs_of(STOCK, STOCK)
    for component in ("sensors", "controller"):
        assert component_resources(designs, component) != component_resources(stock, component)


@pytest.mark.parametrize(
    ("rates", "message"),
    [
        (Rates(star_tracker=0.1024), "Rates.star_tracker = 0.1024 s must be a whole multiple of the step of 0.005 s"),
        (Rates(plant=2e-3), "Rates.controller = 0.005 s must be a whole multiple of the step of 0.002 s"),
        (Rates(sensors=2e-3), "Rates.controller = 0.005 s must be a whole multiple of the step of 0.002 s"),
        (
            Rates(plant=2e-3, sensors=3e-3, controller=6e-3, star_tracker=0.12),
            "Rates.sensors = 0.003 s must be a whole multiple of the step of 0.002 s",
        ),
    ],
)
def test_periods_between_which_samples_would_be_missed_or_late_are_refused(rates, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        build_design(replace(STOCK, rates=rates))


def test_every_unit_is_known():
    for path in paths(STOCK):
        owner = type(value_at(STOCK, path[:-1]))
        # weights are of squares of different units, and a choice has none
        if (
            path not in NOT_HERE
            and owner not in (Configuration, Release)
            and owner.__name__ != "Weights"
            and path[-1] not in CHOICES
        ):
            assert quantity(owner, path[-1]).unit in UNITS, path


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Wheel(inertia=0.0), r"^Wheel\.inertia \[kg\.m2\] must be > 0, got 0\.0$"),
        (lambda: Rates(plant=0.0), r"^Rates\.plant \[s\] must be >= 1e-06 and <= 3600, got 0\.0$"),
        (lambda: Slew(authority=1.1), r"^Slew\.authority \[1\] must be > 0 and <= 1, got 1\.1$"),
        (lambda: Slew(authority=float("nan")), r"must be > 0 and <= 1, got nan$"),
        (lambda: Slew(start_time=float("nan")), r"^Slew\.start_time \[s\] must be a number, got nan$"),
        (lambda: SensorNoise(gyro=-1e-9), r"^SensorNoise\.gyro \[rad/s\] must be >= 0 and <= 0\.0174533, got -1e-09$"),
        (lambda: replace(STOCK.plate, poisson_ratio=0.5), r"must be > -1 and < 0\.5, got 0\.5$"),
        (
            lambda: replace(STOCK.plate, damping_frequencies=(0.5, 0.0)),
            r"^Plate\.damping_frequencies \[Hz\] must be > 0",
        ),
        (lambda: quantity(Slew, "duration"), r"^Slew\.duration: no such parameter with a unit$"),
    ],
)
def test_values_out_of_range_are_refused_by_name(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_limits_of_a_range():
    half_open = Range(above=0.0, maximum=1.0)
    assert [value in half_open for value in (-1.0, 0.0, 0.5, 1.0, 1.5)] == [False, False, True, True, False]
    assert (half_open.least, half_open.most) == (0.0, 1.0)
    assert (Range().least, Range(below=2.0).most) == (None, 2.0)
