"""Tests of the options of runs of systems, of the paper, of branches and campaigns."""

from .shared import HERE, JSON

_TIMING = "lockstep/ssp/test_timing.py::test_command_line_overrides_the_fmus"
_RECORD = "lockstep/run/test_run.py::test_the_run_record_describes_the_run"
_BRANCH = "lockstep/checkpoint/test_branch.py::test_the_command_line_branches_without_a_system_file"
_LEFT_OUT = "lockstep/checkpoint/test_branch.py::test_what_was_left_out_begins_anew_only_when_told"
_RESUME = "lockstep/checkpoint/test_resume.py::test_a_run_that_was_ended_goes_on_and_leaves_the_same_bytes"
_SHADOW = "lockstep/shadow/test_shadow.py::test_shadow_acts_at_its_own_rate_without_a_jump"
_ADAPTER = "system/test_adapter.py::test_our_controller_in_foreign_conventions_gives_the_same_run"
_VALUES = "flexbench/cli/test_option_values.py::test_an_option_reaches_the_study_with_its_value"
_PAPER = "flexbench/studies/paper/test_table.py::"
_JOBS = "system/test_bad_input.py::test_ctrl_c_in_the_study_stops_every_process_and_leaves_readable_runs"
_SAMPLES = "lockstep/run/test_run.py::test_every_sample_carries_the_time_at_which_it_is_true"
_VALUE_FILE = "flexbench/cli/test_option_values.py::"
_PACED = "lockstep/cli/test_paced_run.py::test_a_paced_run_says_so"
_CAMPAIGN = "flexbench/cli/campaign/test_campaign_command.py::test_"

RUN = dict.fromkeys(("--delay", "--step-size", "--tick", "--continuous", "--sampled"), _TIMING) | {
    **dict.fromkeys(("--out", "--stop-time"), _SAMPLES),
    **dict.fromkeys(("--set", "--record", "--record-period"), _RECORD),
    **dict.fromkeys(("--replace", "--adapter"), _ADAPTER),
    "--faults": "lockstep/faults/test_kinds.py::test_every_kind_gives_its_sequence",
    **dict.fromkeys(("--shadow", "--shadow-adapter", "--switchover", "--blend"), _SHADOW),
    "--start-time": "lockstep/checkpoint/test_start_time.py"
    "::test_the_command_line_sets_the_start_time_and_a_run_is_resumed_from_its_record",
    "--input": "lockstep/plan/test_input_files.py"
    "::test_one_fmu_alone_takes_names_of_its_variables_and_other_delimiters",
    **dict.fromkeys(("--isolate", "--share-process"), f"{HERE}::test_the_process_of_a_component_is_recorded"),
    "--step-limit": "lockstep/processes/test_hostile_fmus.py::test_a_run_ends_with_one_line_and_keeps_earlier_rows",
    "--tolerance": "lockstep/run/test_start_values.py::test_command_line_takes_a_tolerance_for_all_and_for_one",
    "--within": "lockstep/ssp/test_packages.py::test_nothing_outside_an_unpacked_package_is_opened",
    "--strict-inputs": "lockstep/ssp/test_foreign_files.py::test_a_run_prints_and_records_its_warnings",
    "--strict": f"{HERE}::test_a_strict_run_refuses_what_is_else_a_warning",
    "--overwrite": "lockstep/run/test_run.py::test_a_folder_with_a_run_is_kept_without_overwrite",
    **dict.fromkeys(("--checkpoint", "--restart-from"), _BRANCH),
    **dict.fromkeys(("--checkpoint-every", "--resume"), _RESUME),
    **dict.fromkeys(("--checkpoint-without", "--reinitialise"), _LEFT_OUT),
    **dict.fromkeys(("--pace", "--realtime-priority", "--core", "--profile"), _PACED),
    "--threads": "lockstep/tick/test_threads.py::test_the_command_line_sets_their_number",
}

EFFECTS = {
    "lockstep run": RUN | JSON,
    "flexsat run": RUN | JSON | {
        "--seed": "flexbench/cli/test_seeds.py::test_a_given_seed_is_set_or_refused_by_the_run",
        "--settling-band": "flexbench/cli/test_closing_table.py"
        "::test_the_table_gives_rms_and_peak_during_the_slew_and_after_its_settling",
        "--mission": "system/test_missions.py::test_the_short_day",
        "--native": "flexbench/loop/test_native_fmus.py::test_a_component_flies_its_native_fmu_if_there_is_one",
        "--accept-infeasible": "flexbench/loop/test_feasibility.py::test_it_runs_if_that_is_accepted",
        "--as-published": _VALUE_FILE + "test_as_published_sets_the_parameters_of_the_release",
    },
    "flexsat branch": JSON | {
        "--vary": "flexbench/engine/test_branches.py::test_all_combinations_are_named_by_their_values",
        **dict.fromkeys(("--set", "--reinitialise", "--stop-time", "--record", "--out", "--jobs"), _VALUES),
    },
    "flexsat paper": JSON
    | {
        **dict.fromkeys(("--as-published", "--corrected"), _PAPER + "test_a_variant_that_was_not_run_has_no_column"),
        "--seeds": _PAPER + "test_a_cell_is_mean_and_standard_deviation_over_the_seeds",
        "--stop-time": _VALUES,
        **dict.fromkeys(("--out", "--fmus", "--jobs"), _JOBS),
        "--margins": "flexbench/studies/paper/test_native.py::test_margins_are_determined_where_they_are_asked_for",
        "--python": "flexbench/studies/paper/test_native.py"
        "::test_python_leaves_them_out_with_the_result_of_an_earlier_study",
    },
    "flexsat campaign": {
        **dict.fromkeys(("--out", "--jobs", "--record"), _CAMPAIGN + "a_campaign_is_run_and_one_of_its_runs_repeated"),
        **dict.fromkeys(("--stop-when", "--json"), _CAMPAIGN + "the_end_of_a_campaign_has_tables_a_page_and_numbers"),
        "--scheduler": "flexbench/campaign/test_dask.py::test_a_cluster_gives_the_same_bytes_and_so_it_does_resumed",
    },
}  # fmt: skip
