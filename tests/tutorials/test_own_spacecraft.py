"""The first hour with a spacecraft of one's own runs as written."""

from tutorials.as_written import run_in_copies


def test_a_spacecraft_of_ones_own_flies_from_an_empty_folder_to_its_studies(tmp_path):
    """Four wheels, two gyros and seven modes, from tables: all studies run on it as on the paper's spacecraft."""
    run_in_copies("docs/own_spacecraft_first_hour", tmp_path)
    assert (tmp_path / "results" / "my" / "report.html").is_file()
    assert (tmp_path / "fmus" / "my" / "array.npz").read_bytes() == (tmp_path / "array.npz").read_bytes()
