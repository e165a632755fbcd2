"""FMUs and systems that are refused before anything runs: one line, and nothing written outside or left behind."""

import zipfile

import pytest

from fmus.bad.bad_fmus import GUID, XML

LIBRARY = "binaries/linux64/bad.so"
DOCTYPE = '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">{}]>'.format(
    "".join(
        f'<!ENTITY {chr(98 + k)} "{10 * f"&{chr(97 + k)};"}">'
        for k in range(9)  # 10^10 letters
    )
)
OUTSIDE = '<!DOCTYPE x [<!ENTITY j SYSTEM "file:///etc/passwd">]>'


def with_entity(doctype):
    """Return a model description whose text holds an entity."""
    return XML.replace("?>\n", f"?>\n{doctype}\n", 1).replace("Sampled gain with noise", "&j;", 1).encode()


# what is done to the archive of a good FMU, and the exit code and the line that follow
REFUSED = {
    "wrong GUID": (
        lambda files: files | {"modelDescription.xml": XML.replace(GUID, "{0}").encode()},
        (1, "b: cannot be instantiated: it logged no reason (a GUID mismatch is one)"),
    ),
    "another platform": (
        lambda files: {name.replace("linux64", "win64"): content for name, content in files.items()},
        (2, "has no binary for linux64; it has win64"),
    ),
    "no library": (
        lambda files: files | {LIBRARY: b"MZ no library"},
        (1, "b: cannot load the FMU: Failed to load shared library"),
    ),
    "missing symbol": (
        lambda files: files | {LIBRARY: files[LIBRARY].replace(b"\0fmi2DoStep\0", b"\0fmi2NoStep\0")},
        (1, "b: cannot load the FMU: "),
    ),
    "zip slip": (
        lambda files: files | {"../../../escaped": b"out"},
        (2, "holds the unsafe path '../../../escaped'; refusing to extract it"),
    ),
    "zip bomb": (
        lambda files: files | {"resources/zeros": bytes(201_000_000)},
        (2, "MB unpack to 201 MB; refusing to extract what looks like a zip bomb"),
    ),
    "entity bomb": (
        lambda files: files | {"modelDescription.xml": with_entity(DOCTYPE)},
        (2, "has a bad model description: "),
    ),
    "entity from outside": (
        lambda files: files | {"modelDescription.xml": with_entity(OUTSIDE)},
        (2, "has a bad model description: "),
    ),
    "truncated": (None, (2, "not a readable zip file")),
}


def write_fmu(path, files):
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, content in files.items():
            archive.writestr(name, content)


def write_package(pair, folder, good):
    """Write an .ssp whose system names an FMU beside the package."""
    system = pair(folder, good, good)
    with zipfile.ZipFile(folder / "pair.ssp", "w") as archive:
        archive.write(system, "SystemStructure.ssd")
    return folder / "pair.ssp"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the folder of all cases."""
    return tmp_path_factory.mktemp("refused")


@pytest.fixture(scope="module")
def found(folder, good, pair, runs):
    """Return how each run ended."""
    with zipfile.ZipFile(good) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    cases = {}
    for name, (change, _) in REFUSED.items():
        place, fmu = folder / name, folder / name / "fmu" / "bad.fmu"
        write_fmu(fmu, files)
        system = pair(place, good, fmu)
        if change is None:
            fmu.write_bytes(fmu.read_bytes()[:-1000])
        else:
            write_fmu(fmu, change(files))
        cases[name] = (place, ("run", system, "--out", place / "out"))
    return runs(cases)


@pytest.mark.parametrize("name", REFUSED)
def test_a_run_is_refused_in_one_line(found, folder, name):
    code, says = REFUSED[name][1]
    ended = found[name]
    assert ended["code"] == code, ended
    (line,) = ended["lines"]
    assert line.startswith("lockstep: b: ")
    assert says in line
    assert "root:" not in line  # of /etc/passwd
    assert (ended["processes"], ended["left"]) == ([], [])
    assert not (folder / name / "out").exists()
    assert not list(folder.rglob("escaped"))


def test_a_system_that_points_outside_its_package_is_refused(pair, good, folder, runs):
    package = write_package(pair, folder / "outside", good)
    ended = runs({"outside": (folder / "outside", ("run", package, "--out", folder / "outside" / "out"))})["outside"]

    assert ended["code"] == 2
    assert "lies outside pair.ssp; put the file into the archive" in ended["lines"][0]
