"""The tutorial of a first run runs as written."""

from tutorials.as_written import run_with_fmus


def test_first_run_runs_top_to_bottom(delivered, tmp_path):
    run_with_fmus("docs/first_run", delivered, tmp_path)
