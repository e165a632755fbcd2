"""Descriptions that refer to others: files, folders, nested packages, variants; and files that must not be opened."""

import zipfile

import pytest

from lockstep import InputError, load_system
from lockstep.ssp.step_times import Timing

SSD, SSP = "application/x-ssp-definition", "application/x-ssp-package"
EACH_MS = Timing(period=1_000_000)


@pytest.fixture
def texts(ssd):
    """Return a document with an echo, and one that holds it twice: as another document, and as a package."""

    def inner(gain):
        ports = ("u[1] input", "u[2] input", "number input Integer", "flag input Boolean", "y[1] output")
        echo = ssd.component("echo", "resources/echo.fmu", *ports)
        values = [(f"echo.{name}", "Real", 0) for name in ("u[2]", "refuse_at")]
        loose = ssd.values(*values[:1], ("echo.number", "Integer", 0), ("echo.flag", "Boolean", 0))
        wires = ssd.connection(".in", "echo.u[1]", ssd.linear(gain)) + ssd.connection("echo.y[1]", ".out")
        ports = ("in input Real unit=rad", "out output")
        bindings = ssd.bindings(ssd.binding(loose))
        return ssd.document(ssd.system("inner", echo, wires, ports, bindings))

    def outer(*parts):
        counter = ssd.component("counter", "resources/counter.fmu", "count output")
        wires = ""
        for name, _, _ in parts:
            wires += ssd.connection("counter.count", f"{name}.in")
        elements = "".join(
            ssd.component(name, source, "in input", "out output", type=kind).replace("%23", "#")
            for name, source, kind in parts
        )
        return ssd.document(ssd.system("outer", counter + elements, wires))

    return inner, outer


@pytest.fixture
def files(tmp_path, texts, fmus, pack):
    """Return the members of a package that holds a description, a package with two variants, and the FMUs."""
    inner, outer = texts
    fmu = {"resources/echo.fmu": fmus["echo"].read_bytes()}
    content = {**fmu, "SystemStructure.ssd": inner(2.0), "VarB.ssd": inner(3.0)}
    package = pack(tmp_path / "inner.ssp", content).read_bytes()
    parts = (("a", "one/inner.ssd", SSD), ("b", "resources/inner.ssp", SSP), ("c", "resources/inner.ssp#VarB.ssd", SSP))
    return {
        "SystemStructure.ssd": outer(*parts),
        "one/inner.ssd": inner(1.0).replace("resources/", "../resources/"),
        "resources/inner.ssp": package,
        "resources/counter.fmu": fmus["counter"].read_bytes(),
        **fmu,
    }


def unpacked(folder, entries):
    for name, content in entries.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return folder


def test_systems_in_other_files_run_from_an_archive_and_from_a_folder(tmp_path, files, pack, run):
    archive = pack(tmp_path / "outer.ssp", files)
    folder = unpacked(tmp_path / "outer folder ä", files)
    packed, loose = (run(load_system(path, EACH_MS)) for path in (archive, folder))
    assert load_system(archive, EACH_MS).path == archive
    assert [c.name for c in load_system(folder, EACH_MS).components] == ["counter", "a/echo", "b/echo", "c/echo"]
    for signals in (packed, loose):
        assert [signals[f"{name}/echo.y[1]"][6] for name in "abc"] == [5.0, 10.0, 15.0]


def test_variant_of_a_package_is_named_after_a_hash(tmp_path, files, pack, run):
    (tmp_path / "p").mkdir()
    with zipfile.ZipFile(unpacked(tmp_path / "x", files) / "resources/inner.ssp") as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    path = pack(tmp_path / "p" / "inner.ssp", content)
    system = load_system(f"{path}#VarB.ssd", EACH_MS)
    assert load_system(system.path, EACH_MS) == system
    assert run(system, overrides={"in": 4})["echo.y[1]"][-1] == 12.0
    assert run(load_system(path, EACH_MS), overrides={"in": 4})["echo.y[1]"][-1] == 8.0


def test_a_system_is_used_twice_by_its_id(load, ssd, fmus, run):
    echo = ssd.component("echo", fmus["echo"], "u[1] input", "y[1] output")
    wires = ssd.connection(".in", "echo.u[1]") + ssd.connection("echo.y[1]", ".out")
    first = ssd.system("first", echo, wires, ("in input", "out output"), id_="stage")
    second = '<ssd:Component name="second" source="#stage" type="application/x-ssp-definition">'
    second += ssd.connectors("in input", "out output") + "</ssd:Component>"
    top = ssd.system("top", first + second, ssd.connection(".u", "first.in") + ssd.connection("first.out", "second.in"),
                     ("u input",))  # fmt: skip
    system = load(top)
    loose = {f"{name}/echo.{port}": "0" for name in ("first", "second") for port in ("u[2]", "flag", "number")}
    values = run(system, overrides={**loose, "u": 3.0})
    assert values["second/echo.y[1]"].tolist()[:3] == [0.0, 0.0, 3.0]  # each stage steps once, then the next reads it
    itself = top.replace('name="second" source="#stage"', 'name="second" source="#outer"').replace(
        'name="top"', 'name="top" id="outer"'
    )
    with pytest.raises(InputError, match=r"second/second: .*foreign\.ssd#outer contains itself"):
        load(itself)
    with pytest.raises(InputError, match="second: source #stag: the file has no System with this id"):
        load(top.replace('source="#stage"', 'source="#stag"'))


REFUSED = [
    ({"one/inner.ssd": None}, r"^a: no such file one/inner\.ssd in .*outer\.ssp"),
    ({"resources/inner.ssp": b"PK no zip"}, r"^.*inner\.ssp: not a readable zip file"),
    (
        {"one/inner.ssd": ('source="../resources/', 'source="../../resources/')},
        r"^a/echo: source .* lies outside outer",
    ),
    (
        {"one/inner.ssd": ('source="../resources/', 'source="/resources/')},
        r"^a/echo: source .* lies outside outer\.ssp",
    ),
    ({"SystemStructure.ssd": ("one/inner.ssd", "SystemStructure.ssd")}, r"^a: .*SystemStructure\.ssd contains itself"),
    ({"SystemStructure.ssd": ("#VarB.ssd", "#VarC.ssd")}, r"^c: no such file VarC\.ssd in .*inner\.ssp"),
    ({"SystemStructure.ssd": ("one/inner.ssd", "one/inner.ssd#x")}, r"^a: .* a part of another file is not supported"),
    (
        {"SystemStructure.ssd": ('"in" kind="input"', '"in" kind="output"')},
        r"^a\.in: declared differently in one/inn",
    ),
    (
        {"SystemStructure.ssd": ('"out" kind', '"result" kind')},
        r"^a\.result: no such connector; one/inner\.ssd has in, out",
    ),
    ({"SystemStructure.ssd": ("<ssd:System ", "<!-- --><ssd:Sistem/><ssd:System ")}, r"line \d+: not valid SSP 1\.0"),
    ({"one/inner.ssd": ('version="1.0"', 'version="3.0"')}, r"inner\.ssd: version '3\.0' is not supported"),
    ({"resources/echo.fmu": None}, r"^a/echo: no such file resources/echo\.fmu in"),
]


@pytest.mark.parametrize(("change", "message"), REFUSED)
def test_a_broken_package_is_refused_in_one_line(tmp_path, files, pack, change, message):
    for name, what in change.items():
        if isinstance(what, tuple):
            assert what[0] in files[name]
            files[name] = files[name].replace(*what, 1)
        elif what is None:
            del files[name]
        else:
            files[name] = what
    with pytest.raises(InputError, match=message) as caught:
        load_system(pack(tmp_path / "outer.ssp", files), EACH_MS)
    assert "\n" not in str(caught.value)


def test_nothing_outside_an_unpacked_package_is_opened(tmp_path, files):
    (tmp_path / "secret").mkdir()
    (tmp_path / "secret" / "inner.ssd").write_text(files["one/inner.ssd"])
    folder = unpacked(tmp_path / "package", files)
    (folder / "one" / "inner.ssd").unlink()
    (folder / "one" / "inner.ssd").symlink_to(tmp_path / "secret" / "inner.ssd")
    with pytest.raises(
        InputError, match=r"a: source one/inner\.ssd lies outside .*package; put the file into that folder"
    ):
        load_system(folder, EACH_MS)
    description = folder / "SystemStructure.ssd"
    description.write_text(files["SystemStructure.ssd"].replace("one/inner.ssd", "../secret/inner.ssd"))
    with pytest.raises(InputError, match=r"a: source \.\./secret/inner\.ssd lies outside .*package"):
        load_system(folder, EACH_MS)
    with pytest.raises(InputError, match=r"a: source \.\./secret/inner\.ssd lies outside .*package"):
        load_system(description, EACH_MS, within=folder)
    (tmp_path / "resources").symlink_to(folder / "resources")
    assert load_system(description, EACH_MS).warnings == (
        f"a: sources outside {folder}, the folder of the system file; --within DIR refuses them",
    )


def test_systems_that_refer_to_each_other_without_end_are_refused(tmp_path, ssd, fmus):
    """Each system holds the next one ten times: 10^8 components in a file of some kilobytes."""
    text = ssd.system("last", ssd.component("echo", fmus["echo"]), id_="s8")
    for level in range(7, 0, -1):
        parts = "".join(ssd.component(f"p{k}", "", type=SSD) for k in range(10))
        text = ssd.system(f"at{level}", parts.replace('source=""', f'source="#s{level + 1}"') + text, id_=f"s{level}")
    (tmp_path / "many.ssd").write_text(ssd.document(ssd.system("top", text)))
    with pytest.raises(InputError, match=r"^at1/p0/p0/.*: more than 10000 elements or 60 levels; systems that refer"):
        load_system(tmp_path / "many.ssd", EACH_MS)


BOMB = "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10 if k else "ha"}">' for k in range(12))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize("place", ["attribute", "text"])
def test_entities_are_refused_before_they_are_read(tmp_path, ssd, fmus, place, encoding):
    text = ssd.document(ssd.system("top", ssd.component("echo", fmus["echo"])))
    text = text.replace('name="foreign"', 'name="&a11;"') if place == "attribute" else text + "&a11;"
    path = tmp_path / "bomb.ssd"
    path.write_text(f'<?xml version="1.0" encoding="{encoding}"?><!DOCTYPE x [{BOMB}]>{text}', encoding=encoding)
    with pytest.raises(InputError, match=r"bomb\.ssd: holds a document type, which may declare entities; remove"):
        load_system(path, EACH_MS)
