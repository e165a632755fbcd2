"""The README's commands run as written."""

from tutorials.as_written import run_with_fmus


def test_readme_runs_top_to_bottom(delivered, tmp_path):
    run_with_fmus("README", delivered, tmp_path)
