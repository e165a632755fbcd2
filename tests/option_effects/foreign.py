"""Tests of the options of what accepts, adapts and measures FMUs of others."""

from .shared import HERE, JSON

_EVERY_FILE = "lockstep/check/report/test_check_report.py::test_good_fmu_gets_0_and_every_file"
_PROBE = "lockstep/check/latency/test_probe_latency.py::"
_SHADOWS = "flexbench/studies/shadow/test_shadow.py::"
_ADAPT = "system/test_adapter.py::"

CHECK = dict.fromkeys(("--html", "--json", "--junit", "--strict"), _EVERY_FILE) | {
    "--static": f"{HERE}::test_a_static_check_runs_nothing",
}
PROBE_LATENCY = {
    **dict.fromkeys(("--step-size", "--steps"), f"{HERE}::test_options_change_what_is_probed"),
    **dict.fromkeys(("--set", "--amplitude"), _PROBE + "test_values_and_amplitudes_decide_what_is_excited"),
    "--kind": _PROBE + "test_integral_is_feedthrough_unless_the_fmu_declares_any_step",
    "--time-limit": _PROBE + "test_bad_setting_is_refused",
    "--json": _PROBE + "test_command_prints_a_matrix_and_writes_json",
}

EFFECTS = {
    "lockstep check": CHECK,
    "flexsat check": CHECK | {
        "--like": "system/test_acceptance.py::test_a_controller_of_the_other_size_misses_wheels",
        "--adapter": "flexbench/adapt/test_adapted_check.py::test_fmu_is_judged_behind_its_adapter",
    },
    **dict.fromkeys(("lockstep probe-latency", "flexsat probe-latency"), PROBE_LATENCY),
    "flexsat adapt": dict.fromkeys(("--like", "--out"),
                                   _ADAPT + "test_a_draft_becomes_an_adapter_by_what_it_says_it_could_not_decide"),
    "flexsat check-adapter": {
        "--apply": "tutorials/test_controller_in_the_loop.py::test_controller_in_the_loop_runs_top_to_bottom",
        "--json": _ADAPT + "test_a_controller_that_cannot_be_judged_is_refused_in_one_line",
        "--adapter": _ADAPT + "test_a_wrong_convention_is_named",
        "--like": _ADAPT + "test_a_controller_that_cannot_be_judged_is_refused_in_one_line",
    },
    "flexsat shadow": JSON
    | {
        "--from": _SHADOWS + "test_residuals_begin_at_the_given_time_and_end_at_the_switchover",
        "--window": "system/test_shadow.py::test_windows_that_do_not_fit_are_refused",
        "--out": f"{HERE}::test_results_of_two_runs_go_to_folders_of_their_own",
    },
}  # fmt: skip
