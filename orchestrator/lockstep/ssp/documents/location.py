"""Locate documents of SSP and resolve their relative sources: nothing may lie outside an archive or a given folder."""

from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from posixpath import normpath
from urllib.parse import parse_qs, unquote, urlsplit

from lockstep.errors import InputError, compact, refuse_undecodable
from lockstep.fmi.safe_zip import is_inside, open_file
from lockstep.ssp.documents.not_a_system import refuse_no_system
from lockstep.ssp.documents.xml import MAIN, Warnings


@dataclass(frozen=True, slots=True, kw_only=True)
class Location:
    """A document on disk or in an archive.

    Attributes
    ----------
    document : inside `archive`, if there is one; else on disk
    archive : the .ssp that holds it; nested ones are `outer.ssp/resources/inner.ssp`
    root : the folder below which its sources have to lie; None: a .ssd alone, which may name any file
    home : sources outside this folder, that of the first document, are warnings; None: they are not
    warnings : of all documents that this one refers to, in the order in which they are read
    outside : elements with sources outside `home`
    """

    document: Path
    archive: Path | None = None
    root: Path | None = None
    home: Path | None = None
    warnings: Warnings = field(default_factory=list, compare=False, repr=False)
    outside: list[str] = field(default_factory=list, compare=False, repr=False)

    def __str__(self) -> str:
        return str(Path(self.archive, self.document) if self.archive else self.document)

    @property
    def all_warnings(self) -> tuple[str, ...]:
        """All warnings, that of sources outside the folder last."""
        where = f"sources outside {self.home}, the folder of the system file; --within DIR refuses them"
        outside = [f"{compact(dict.fromkeys(self.outside))}: {where}"] if self.outside else []
        return tuple(dict.fromkeys((*self.warnings, *outside)))

    def read(self, name: str) -> bytes:
        """Return the bytes of the document, or raise InputError that begins with `name`."""
        with open_file(self.document, self.archive, name) as stream:
            return stream.read()

    def resolve(self, source: str, name: str, inside: str = "") -> tuple["Location", str]:
        """Return the file that a source of this document refers to, and its fragment. Raises InputError.

        With `inside` it is the file of the same name in the folder of that name beside the one referred to.
        """
        parts = urlsplit(source)
        if parts.scheme == "proxyfmu" and parse_qs(parts.query).get("file"):
            self.warnings.append(f"{name}: source {source} is run here, without a proxy")
            parts = urlsplit(parse_qs(parts.query)["file"][0])
        if parts.scheme not in ("", "file") or parts.netloc:
            raise InputError(f"{name}: source {source} is not a file; copy it into the folder of the system file")
        path, fragment = unquote(parts.path), unquote(parts.fragment)
        if not path or "\0" in path:
            raise InputError(f"{name}: source {source!r} names no file; give the path of one")
        if inside:
            path = str(PurePosixPath(path).parent / inside / PurePosixPath(path).name)
        if self.archive is not None:
            member = normpath((PurePosixPath(self.document.as_posix()).parent / path).as_posix())
            if not is_inside(member):
                what = f"{name}: source {source} lies outside {self.archive.name}"
                raise InputError(f"{what}; put the file into the archive")
            return replace(self, document=Path(member)), fragment
        file = Path(self.document.parent, path).resolve()
        if self.root is not None and not file.is_relative_to(self.root.resolve()):
            link = (
                ""
                if file == Path(normpath(self.document.parent / path))
                else f" itself: it is, or passes, a link to {file}"
            )
            what = f"{name}: source {source} lies outside {self.root}; put the file into that folder{link}"
            raise InputError(what)
        if self.root is None and self.home is not None and not file.is_relative_to(self.home.resolve()):
            self.outside.append(name)
        return replace(self, document=file), fragment

    def inner(self, member: str) -> "Location":
        """Return a document inside this file, which is an archive."""
        archive = Path(self.archive, self.document) if self.archive else self.document
        return Location(document=Path(member), archive=archive, warnings=self.warnings)

    def member(self, source: str, name: str) -> "Location":
        """Return the file that a source relative to this file, an archive, refers to. Raises InputError."""
        parts = urlsplit(source)
        inside = normpath(unquote(parts.path))
        if parts.scheme or parts.netloc or not parts.path or not is_inside(inside):
            raise InputError(f"{name}: source {source} is not inside {self.document.name}; put the file into it")
        return self.inner(inside)


def location_of(path: Path, within: Path | None = None) -> Location:
    """Return the document of a path: a .ssd, a package's folder, a .ssp, or `package.ssp#Variant.ssd`.

    A folder confines its documents; those of a .ssd may lie anywhere, with a warning, or have to lie in `within`.
    """
    path = path.absolute()
    refuse_undecodable(path)
    file, hash_, variant = path.name.partition("#")
    if hash_ and not path.exists() and file.lower().endswith(".ssp"):
        return Location(document=path.with_name(file)).inner(variant)
    if path.is_dir() and (path / MAIN).exists():
        return Location(document=path / MAIN, root=within or path)
    refuse_no_system(path)
    if path.suffix.lower() == ".ssp" and path.is_file():
        return Location(document=path).inner(MAIN)
    return Location(document=path, root=within, home=path.parent)
