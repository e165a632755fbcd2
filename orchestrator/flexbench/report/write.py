"""Write the page of some runs to a file, complete or not at all; print it as PDF on request."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from flexbench.runs.run_folder import refuse_own_file
from lockstep import InputError

from .compose import compose_page
from .pdf import find_browser, print_pdf
from .results import load_results
from .run_data import Window
from .study_table import study_folders

PAGE = "report.html"


def write_report(
    paths: Sequence[Path],
    out: Path | None = None,
    pdf: bool = False,
    studies: Sequence[Path] = (),
    window: Window | None = None,
) -> list[Path]:
    """Write one page of all runs in the given folders; return what was written.

    A run that cannot be read is named on the page, with the reason, and does not stop the others.

    Parameters
    ----------
    paths : results folders of runs, or folders of such folders; several are compared
    out : page to write; None for report.html in the first folder
    pdf : also print the page as PDF, to the same folder
    studies : further folders with the table of a study and its figures
    window : part of the time to plot and to animate, begin and end [s]; a short one is kept row by row

    Raises
    ------
    InputError
        If a folder holds no run, none can be read, the page cannot be written, or no browser is there to print the PDF.
    """
    paths = [Path(path) for path in paths]
    results, unread = load_results(paths)
    studies = [*studies, *study_folders(paths)]
    out = out or paths[0] / PAGE
    if out.is_dir():
        raise InputError(f"{out}: is a folder; give a file, for example {out / PAGE}")
    refuse_own_file(out)
    if pdf:
        find_browser()  # before the work
    page = compose_page(results, studies, window, unread)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{out.name}-", dir=out.parent) as partial:
            file = Path(partial) / PAGE
            file.write_text(page, encoding="utf-8")
            printed = print_pdf(file, Path(partial) / "report.pdf") if pdf else None
            file.replace(out)
            if printed is None:
                return [out]
            beside = out.with_suffix(".pdf")
            printed.replace(beside)
            return [out, beside]
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror or error}); choose another file") from None
