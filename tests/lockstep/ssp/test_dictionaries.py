"""Signal dictionaries: buses that systems at several levels write to and read from."""

from dataclasses import replace
from math import pi

import pytest

from lockstep import InputError


@pytest.fixture
def bus(ssd, fmus):
    """Return a system whose parts meet on a bus only: the writer at the top, the readers in systems of their own."""

    def made(dictionary, more=""):
        link = ssd.connection
        source = ssd.component("source", fmus["angle"], "degrees output Real unit=deg")
        to = ssd.reference("to", "bus", "angle inout")
        parts = source + to
        for name in ("one", "two"):
            sink = ssd.component("sink", fmus["angle"], "radians input Real unit=rad", "free input")
            tap = ssd.reference("tap", "bus", "angle output")
            wires = link("tap.angle", "sink.radians", ssd.linear(2.0)) + link("tap.angle", "sink.free")
            parts += ssd.system(name, tap + sink, wires)
        text = ssd.system("top", parts, link("source.degrees", "to.angle", ssd.linear(1.0, 1.0)) + more)
        found = f"<ssd:SignalDictionaries>{dictionary}</ssd:SignalDictionaries>" if dictionary else ""
        return f"{text.removesuffix('</ssd:System>')}{found}</ssd:System>"

    return made


LOOSE = {"source.radians": 0, "source.kelvin": 0, "source.free": 0, "one/sink.kelvin": 0, "two/sink.kelvin": 0}


@pytest.mark.parametrize("inline", [True, False])
def test_readers_at_any_level_get_the_value_of_an_entry(tmp_path, load, ssd, bus, run, inline):
    dictionary = ssd.dictionary("angle Real unit=rad", "spare Integer")
    (tmp_path / "bus.ssb").write_text(dictionary)
    given = f'<ssd:SignalDictionary name="bus">{dictionary}</ssd:SignalDictionary>'
    system = load(bus(given if inline else '<ssd:SignalDictionary name="bus" source="bus.ssb"/>'))
    assert [str(c) for c in system.connections] == [
        f"source.degrees -> {name}/sink.{port}" for name in ("one", "two") for port in ("radians", "free")
    ]
    values = run(system, overrides=LOOSE)
    for name in ("one", "two"):  # 180 deg, in rad on the bus, plus 1 rad; there, twice that, and as it is
        assert values[f"{name}/sink.radians_seen"][-1] == pytest.approx(2 * (pi + 1), rel=1e-15)
        assert values[f"{name}/sink.free_seen"][-1] == pytest.approx(pi + 1, rel=1e-15)


INLINE = '<ssd:SignalDictionary name="bus">{}</ssd:SignalDictionary>'
REFUSED = [  # entries, or the whole text; what is connected to the entry beside the source; message
    ("", "", r"^to: no signal dictionary bus in this system or around it; there are none"),
    (("angel Real",), "", r"^to\.angle: signal dictionary bus has no such entry; it has angel; did you mean angel\?"),
    (("angle Integer",), "", r"^to\.angle: declared differently in signal dictionary bus; correct one"),
    (INLINE.format(""), "", r"^the system: bus: holds 0 elements; give one SignalDictionary, or a source"),
    ('<ssd:SignalDictionary name="bus" source="no.ssb"/>', "", r"^the system: bus: no such file .*no\.ssb"),
    (("angle Real", "angle Real"), "", r"bus: entry angle: declared twice"),
    (("angle Real",), "source.degrees", r"to\.angle: the input is already connected to source"),
    (("angle Real",), "to.angle", r"both ends may be the source; give one of them the kind input or output"),
]


@pytest.mark.parametrize(("entries", "start", "message"), REFUSED)
def test_bad_dictionary_is_refused_in_one_line(load, ssd, bus, entries, start, message):
    more = ssd.connection(start, "to.angle") if start else ""
    dictionary = entries if isinstance(entries, str) else INLINE.format(ssd.dictionary(*entries))
    with pytest.raises(InputError, match=message) as caught:
        load(bus(dictionary, more=more))
    assert "\n" not in str(caught.value)


def test_entry_without_a_source_leaves_its_readers_without_a_value(load, ssd, fmus, run):
    echo = ssd.component("echo", fmus["echo"], "u[1] input")
    text = ssd.system("top", echo + ssd.reference("bus", "bus", "a output"), ssd.connection("bus.a", "echo.u[1]"))
    given = f"<ssd:SignalDictionaries>{INLINE.format(ssd.dictionary('a Real'))}</ssd:SignalDictionaries></ssd:System>"
    system = replace(load(text.removesuffix("</ssd:System>") + given), strict_inputs=True)
    with pytest.raises(InputError, match=r"^echo\.u\[1\.\.2\], flag, number: not connected and without a value"):
        run(system)
