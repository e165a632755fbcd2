"""Tests of the options of studies, of a design or of many runs."""

from .shared import JSON

_VALUES = "flexbench/cli/test_option_values.py::test_an_option_reaches_the_study_with_its_value"
_MEASURED = "flexbench/studies/margins/test_margins_measured.py::"
_MULTISINE = _MEASURED + "test_a_multisine_has_its_lines_and_no_others"
_VENDOR = "system/test_margins.py::test_the_command_measures_a_vendors_controller"
_BUDGET = "flexbench/studies/budget/test_budget.py::"
_SPLIT = "system/test_budget.py::test_the_seed_is_that_of_every_run"
_EVALUATED = "system/test_budget.py::test_results_that_may_only_be_read_are_evaluated_into_another_folder"
_ROBUSTNESS = "flexbench/studies/robustness/test_robustness.py::"
_LAYOUT = "flexbench/studies/layouts/test_study.py::"
_WATERFALL = "system/test_budget.py::test_waterfall_of_three_speeds_peaks_at_the_resonance"
_VALUE_FILE = "flexbench/cli/test_option_values.py::"
_MARGINS = "system/test_margins.py::"

EFFECTS = {
    "flexsat margins": JSON
    | {
        **dict.fromkeys(("--replace", "--set", "--out", "--amplitude", "--periods", "--settle"), _VENDOR),
        "--adapter": "examples/test_vendor_controller.py::test_margins_are_measured_through_an_adapter",
        "--analytic-only": _VALUE_FILE + "test_measurement_options_beside_analytic_only_are_refused",
        **dict.fromkeys(("--modes", "--gains"), "flexbench/studies/margins/test_real_plant.py::"
                        "test_the_command_finds_the_published_design_unstable_on_30_modes"),
        "--find-delay": _MARGINS + "test_the_delay_that_destabilises_the_co_simulation_is_the_analysed_one",
        **dict.fromkeys(("--seed", "--plant"), _VALUES),
        "--delay": "flexbench/studies/margins/test_margins.py::test_delays_of_the_system_and_of_the_margin_act_alike",
        "--noise-free": _MARGINS + "test_the_measured_margins_are_the_designs_without_noise",
        **dict.fromkeys(("--band", "--lines", "--length"), _MULTISINE),
        "--zoom": _MEASURED + "test_zoom_adds_lines_where_a_mode_is_narrower_than_their_spacing",
        "--slow-period": _MEASURED + "test_no_line_is_an_alias_of_another",
        "--directions": "flexbench/studies/margins/test_margins.py::test_one_direction_opened_leaves_the_others_closed",
        "--python": "flexbench/studies/test_fmus_of_sweeps.py::test_margins_are_the_same_with_both_kinds",
        "--controller": _MARGINS + "test_bad_input_gets_one_line",
    },
    "flexsat budget": JSON
    | {
        "--requirements": "system/test_budget.py::test_budget_judges_requirements_by_its_exit_code",
        **dict.fromkeys(("--split", "--seed", "--stop-time"), _SPLIT),
        "--out": _EVALUATED,
        **dict.fromkeys(("--python", "--jobs"), _VALUES),
        "--window": _BUDGET + "test_mean_error_of_a_sine",
        "--separation": _BUDGET + "test_drift_of_a_sine",
        "--observation": _BUDGET + "test_reproducibility_of_a_ramp_and_a_periodic_error",
        "--level": _BUDGET + "test_value_at_a_level_is_an_order_statistic",
        "--from": _BUDGET + "test_bad_windows_levels_and_starts_are_refused",
    },
    "flexsat spectra": JSON
    | {
        "--resolution": "flexbench/studies/spectra/test_spectra.py::test_bad_resolution_is_refused",
        "--confidence": "flexbench/studies/spectra/test_spectra.py::"
                        "test_bounds_cover_the_true_density_with_their_confidence",
        "--from": _VALUES,
        "--out": _EVALUATED,
    },
    "flexsat health": JSON
    | {
        "--seeds": "flexbench/studies/health/test_health.py::test_bounds_of_an_average_are_those_of_chi_square",
        **dict.fromkeys(("--stop-time", "--set", "--input", "--out", "--python", "--jobs"), _VALUES),
    },
    "flexsat robustness": JSON
    | {
        "--levels": _ROBUSTNESS + "test_errors_are_shifts_or_draws_of_the_level",
        **dict.fromkeys(("--vary", "--damping", "--inertia", "--participation", "--modes"),
                        _ROBUSTNESS + "test_each_error_reaches_the_plant"),
        "--stop-time": _ROBUSTNESS + "test_bad_levels_and_stop_times_are_refused_before_anything_runs",
        **dict.fromkeys(("--configuration", "--scenario", "--controller-design", "--seeds"), _VALUES),
        **dict.fromkeys(("--out", "--fmus", "--python", "--jobs"), _VALUES),
    },
    "flexsat compare-layouts": JSON
    | {
        "--configuration": _LAYOUT + "test_two_spacecraft_that_are_built_are_compared_in_the_order_given",
        "--dispersion": "flexbench/studies/layouts/test_dispersions.py::test_limits_are_given_in_percent_and_checked",
        "--stop-time": _LAYOUT + "test_a_slew_that_leaves_no_time_after_it_is_refused_before_anything_runs",
        "--settling-band": _LAYOUT + "test_a_slew_is_compared_while_it_lasts_and_from_its_end_on",
        "--set": _LAYOUT + "test_a_limit_cycle_is_lost_and_named",
        **dict.fromkeys(("--seeds", "--scenario", "--out", "--fmus", "--python", "--jobs"), _VALUES),
    },
    "flexsat waterfall": JSON
    | {
        "--as-published": "flexbench/studies/waterfall/test_waterfall.py::"
                          "test_a_sweep_as_published_flies_25_modes_and_is_named_so",
        **dict.fromkeys(("--points", "--speed-range", "--stop-time", "--out"), _WATERFALL),
        **dict.fromkeys(("--seed", "--python", "--jobs"), _VALUES),
    },
    "flexsat equivalence": JSON
    | dict.fromkeys(("--configuration", "--scenario", "--seed", "--stop-time", "--record", "--out", "--fmus",
                     "--native"), _VALUES),
}  # fmt: skip
