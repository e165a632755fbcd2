"""Tests of the options of what reads results."""

from .shared import JSON

EFFECTS = {
    "flexsat report": {
        "--out": "system/test_report_files.py::test_run_with_parts_of_arrays_has_a_page_of_these",
        "--time-range": "flexbench/report/test_results.py::test_short_window_keeps_every_row",
        "--pdf": "system/test_report_files.py::test_pdf_on_request",
    },
    "flexsat figures": JSON
    | {
        "--robust-design": "flexbench/figures/test_robust_design.py::test_the_command_prints_the_tables_and_draws",
        "--as-published": "flexbench/figures/test_figure_lists.py::test_the_command_draws_the_design_as_published",
        **dict.fromkeys(("--configuration", "--out"),
                        "system/test_figures.py::test_the_design_is_drawn_without_results"),
    },
    "flexsat export": {
        "--format": "flexbench/runs/test_export.py::test_hdf5_read_by_h5py",
        "--out": "flexbench/runs/test_export.py::test_failed_export_leaves_no_file",
        "--signals": "flexbench/runs/test_export.py::test_only_requested_signals_are_written",
    },
}  # fmt: skip
