"""Every option of every command has an effect on the result, or is refused: the test that shows it, by option.

A new option fails without one, in any file; where `test_option_values.py` follows it to a study, one of the study."""

import ast
import tomllib
from functools import cache
from pathlib import Path

import click
import pytest

from flexbench.cli.parser import PROGRAM as FLEXSAT
from lockstep import Component, Connection, System, load_system, write_ssd
from lockstep.__main__ import PROGRAM as LOCKSTEP

ROOT = Path(__file__).parents[2]
PROGRAMS = {"flexsat": FLEXSAT, "lockstep": LOCKSTEP}
MS = 1_000_000  # [ns]
HERE = "flexbench/cli/test_option_effects.py"

_TIMING = "lockstep/ssp/test_timing.py::test_command_line_overrides_the_fmus"
_RECORD = "lockstep/run/test_run.py::test_the_run_record_describes_the_run"
_BRANCH = "lockstep/checkpoint/test_branch.py::test_the_command_line_branches_without_a_system_file"
_LEFT_OUT = "lockstep/checkpoint/test_branch.py::test_what_was_left_out_begins_anew_only_when_told"
_RESUME = "lockstep/checkpoint/test_resume.py::test_a_run_that_was_ended_goes_on_and_leaves_the_same_bytes"
_SHADOW = "lockstep/shadow/test_shadow.py::test_shadow_acts_at_its_own_rate_without_a_jump"
_ADAPTER = "system/test_adapter.py::test_our_controller_in_foreign_conventions_gives_the_same_run"
_SPACECRAFT = "flexbench/cli/spacecraft/test_spacecraft.py::"
_SHOWN = f"{HERE}::test_timing_options_change_what_is_shown"
_SSP = "system/test_write_ssp.py::test_the_loop_is_that_with_the_adapter"
_EVERY_FILE = "lockstep/check/report/test_check_report.py::test_good_fmu_gets_0_and_every_file"
_PROBE = "lockstep/check/latency/test_probe_latency.py::"
_VALUES = "flexbench/cli/test_option_values.py::test_an_option_reaches_the_study_with_its_value"
_MEASURED = "flexbench/studies/margins/test_margins_measured.py::"
_MULTISINE = _MEASURED + "test_a_multisine_has_its_lines_and_no_others"
_VENDOR = "system/test_margins.py::test_the_command_measures_a_vendors_controller"
_BUDGET = "flexbench/studies/budget/test_budget.py::"
_SPLIT = "system/test_budget.py::test_the_seed_is_that_of_every_run"
_EVALUATED = "system/test_budget.py::test_results_that_may_only_be_read_are_evaluated_into_another_folder"
_ROBUSTNESS = "flexbench/studies/robustness/test_robustness.py::"
_PAPER = "flexbench/studies/paper/test_table.py::"
_LAYOUT = "flexbench/studies/layouts/test_study.py::"
_WATERFALL = "system/test_budget.py::test_waterfall_of_three_speeds_peaks_at_the_resonance"
_JOBS = "system/test_bad_input.py::test_ctrl_c_in_the_study_stops_every_process_and_leaves_readable_runs"
_ADAPTED = "lockstep/ssp/test_adapted_package.py::"
_BUILT = "flexsat/fmu/test_built_components.py::"
_SAME_BYTES = _BUILT + "test_builds_in_another_process_and_folder_and_on_another_processor_give_equal_bytes"
_SAMPLES = "lockstep/run/test_run.py::test_every_sample_carries_the_time_at_which_it_is_true"
_VALUE_FILE = "flexbench/cli/test_option_values.py::"
_MARGINS = "system/test_margins.py::"
_EXPORTED_C = "flexbench/cli/test_export_c.py::test_every_option_changes_what_is_written"
_SHADOWS = "flexbench/studies/shadow/test_shadow.py::"
_PACED = "lockstep/cli/test_paced_run.py::test_a_paced_run_says_so"
_CAMPAIGN = "flexbench/cli/campaign/test_campaign_command.py::test_"
_ADAPT = "system/test_adapter.py::"

SHOWN = dict.fromkeys(("--delay", "--step-size", "--tick", "--continuous", "--sampled"), _SHOWN)
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
WRITE_SSP = dict.fromkeys(("--replace", "--adapter", "--source", "--out"), _SSP) | {
    **dict.fromkeys(("--delay", "--step-size"), f"{HERE}::test_a_written_package_has_the_delay_and_the_step"),
    "--partial": _ADAPTED + "test_entry_without_a_connection_is_listed_and_refused_or_left_out",
}
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
_BUNDLE = "lockstep/bundle/test_command.py::test_"
EFFECTS = {
    **dict.fromkeys(("lockstep bundle", "flexsat bundle"), dict.fromkeys(
        ("--out", "--input", "--output", "--parameter", "--multiple-of", "--set", *SHOWN),
        _BUNDLE + "every_option_changes_the_bundle",
    ) | {"--platforms": _BUNDLE + "zig_builds_for_chosen_platforms_that_all_fmus_have"}),
    **dict.fromkeys(("lockstep write-ssp", "flexsat write-ssp"), WRITE_SSP),
    **dict.fromkeys(("lockstep probe-latency", "flexsat probe-latency"), PROBE_LATENCY),
    "lockstep run": RUN,
    "lockstep show": SHOWN, "flexsat new": {},
    "lockstep check": CHECK,
    "flexsat run": RUN | {
        "--seed": "flexbench/cli/test_seeds.py::test_a_given_seed_is_set_or_refused_by_the_run",
        "--settling-band": "flexbench/cli/test_closing_table.py"
        "::test_the_table_gives_rms_and_peak_during_the_slew_and_after_its_settling",
        "--mission": "system/test_missions.py::test_the_short_day",
        "--native": "flexbench/loop/test_native_fmus.py::test_a_component_flies_its_native_fmu_if_there_is_one",
        "--accept-infeasible": "flexbench/loop/test_feasibility.py::test_it_runs_if_that_is_accepted",
        "--as-published": _VALUE_FILE + "test_as_published_sets_the_parameters_of_the_release",
    },
    "flexsat check": CHECK | {
        "--like": "system/test_acceptance.py::test_a_controller_of_the_other_size_misses_wheels",
        "--adapter": "flexbench/adapt/test_adapted_check.py::test_fmu_is_judged_behind_its_adapter",
    },
    "flexsat timeline": SHOWN
    | dict.fromkeys(("--ticks", "--svg"), "system/test_foreign_package.py::test_the_command_shows_and_draws_it"),
    "flexsat build": {
        "--configuration": "flexbench/loop/test_build.py::test_building_one_configuration_keeps_the_unchanged_other",
        **dict.fromkeys(("--out", "--flat"), _SAME_BYTES),
        "--missions": "system/test_missions.py::test_the_short_day",
        "--no-native": "flexsat/fmu/native/test_native_components.py::test_each_layout_has_them_beside_the_others",
        "--fmi3": "flexbench/loop/test_build.py::test_fmus_of_fmi_3_have_a_folder_with_systems_in_the_manifest",
        "--platforms": "flexbench/cli/test_build_platforms.py::test_each_platform_is_built_once_in_the_usual_order",
        "--needs-execution-tool": "flexsat/fmu/test_export.py::test_a_build_declares_that_a_tool_is_needed_if_asked_to",
    },
    "flexsat paper": {
        **dict.fromkeys(("--as-published", "--corrected"), _PAPER + "test_a_variant_that_was_not_run_has_no_column"),
        "--seeds": _PAPER + "test_a_cell_is_mean_and_standard_deviation_over_the_seeds",
        "--stop-time": _VALUES,
        **dict.fromkeys(("--out", "--fmus", "--jobs"), _JOBS),
        "--python": "flexbench/studies/paper/test_native.py"
        "::test_python_leaves_them_out_with_the_result_of_an_earlier_study",
    },
    "flexsat branch": {
        "--vary": "flexbench/engine/test_branches.py::test_all_combinations_are_named_by_their_values",
        **dict.fromkeys(("--set", "--reinitialise", "--stop-time", "--record", "--out", "--jobs"), _VALUES),
    },
    "flexsat report": {
        "--out": "system/test_report_files.py::test_run_with_parts_of_arrays_has_a_page_of_these",
        "--time-range": "flexbench/report/test_results.py::test_short_window_keeps_every_row",
        "--pdf": "system/test_report_files.py::test_pdf_on_request",
    },
    "flexsat figures": {
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
    "flexsat export-c": dict.fromkeys(("--configuration", "--design", "--precision", "--out", "--fmus"), _EXPORTED_C),
    "flexsat margins": {
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
    "flexsat budget": {
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
    "flexsat spectra": {
        "--resolution": "flexbench/studies/spectra/test_spectra.py::test_bad_resolution_is_refused",
        "--confidence": "flexbench/studies/spectra/test_spectra.py::"
                        "test_bounds_cover_the_true_density_with_their_confidence",
        "--from": _VALUES,
        "--out": _EVALUATED,
    },
    "flexsat health": {
        "--seeds": "flexbench/studies/health/test_health.py::test_bounds_of_an_average_are_those_of_chi_square",
        **dict.fromkeys(("--stop-time", "--out", "--python", "--jobs"), _VALUES),
    },
    "flexsat robustness": {
        "--levels": _ROBUSTNESS + "test_errors_are_shifts_or_draws_of_the_level",
        **dict.fromkeys(("--vary", "--damping", "--inertia", "--participation", "--modes"),
                        _ROBUSTNESS + "test_each_error_reaches_the_plant"),
        "--stop-time": _ROBUSTNESS + "test_bad_levels_and_stop_times_are_refused_before_anything_runs",
        **dict.fromkeys(("--configuration", "--scenario", "--controller-design", "--seeds"), _VALUES),
        **dict.fromkeys(("--out", "--fmus", "--python", "--jobs"), _VALUES),
    },
    "flexsat compare-layouts": {
        "--dispersion": "flexbench/studies/layouts/test_dispersions.py::test_limits_are_given_in_percent_and_checked",
        "--stop-time": _LAYOUT + "test_a_slew_that_leaves_no_time_after_it_is_refused_before_anything_runs",
        "--settling-band": _LAYOUT + "test_a_slew_is_compared_while_it_lasts_and_from_its_end_on",
        "--set": _LAYOUT + "test_a_limit_cycle_is_lost_and_named",
        **dict.fromkeys(("--seeds", "--scenario", "--out", "--fmus", "--python", "--jobs"), _VALUES),
    },
    "flexsat campaign": {
        **dict.fromkeys(("--out", "--jobs", "--record"), _CAMPAIGN + "a_campaign_is_run_and_one_of_its_runs_repeated"),
        **dict.fromkeys(("--stop-when", "--json"), _CAMPAIGN + "the_end_of_a_campaign_has_tables_a_page_and_numbers"),
        "--scheduler": "flexbench/campaign/test_dask.py::test_a_cluster_gives_the_same_bytes_and_so_it_does_resumed",
    },
    "flexsat waterfall": {
        "--as-published": "flexbench/studies/waterfall/test_waterfall.py::"
                          "test_a_sweep_as_published_flies_25_modes_and_is_named_so",
        **dict.fromkeys(("--points", "--speed-range", "--stop-time", "--out"), _WATERFALL),
        **dict.fromkeys(("--seed", "--python", "--jobs"), _VALUES),
    },
    "flexsat shadow": {
        "--from": _SHADOWS + "test_residuals_begin_at_the_given_time_and_end_at_the_switchover",
        "--window": "system/test_shadow.py::test_windows_that_do_not_fit_are_refused",
        "--out": f"{HERE}::test_results_of_two_runs_go_to_folders_of_their_own",
    },
    "flexsat equivalence": dict.fromkeys(("--configuration", "--scenario", "--seed", "--stop-time", "--record", "--out",
                                          "--fmus", "--native"), _VALUES),
    "flexsat adapt": dict.fromkeys(("--like", "--out"),
                                   _ADAPT + "test_a_draft_becomes_an_adapter_by_what_it_says_it_could_not_decide"),
    "flexsat check-adapter": {
        "--adapter": _ADAPT + "test_a_wrong_convention_is_named",
        "--like": _ADAPT + "test_a_controller_that_cannot_be_judged_is_refused_in_one_line",
    },
    "flexsat modal": {"--out": "flexbench/cli/spacecraft/test_modal.py::test_tables_become_a_modal_file"},
    "flexsat spacecraft": {
        "--file": _SPACECRAFT + "test_the_file_of_a_built_in_spacecraft_is_one_to_start_from",
        "--list-modes": _SPACECRAFT + "test_the_start_is_shown",
        "--schema": _SPACECRAFT + "test_the_schema_is_the_page_of_the_documentation",
        "--draw": _SPACECRAFT + "test_a_spacecraft_is_drawn",
    },
}  # fmt: skip
COMMANDS = [(label, name) for label, program in PROGRAMS.items() for name in program.list_commands(None)]


def command(label, name):
    """Return a command of a program."""
    return PROGRAMS[label].get_command(None, name)


def options_of(label, name):
    """Return the long names of a command's options."""
    options = [one for one in command(label, name).params if isinstance(one, click.Option)]
    return {max(one.opts, key=len) for one in options} - {"--traceback"}


@cache
def names_in(file):
    """Return the names of the tests in a file."""
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")}


@pytest.mark.parametrize(("label", "name"), COMMANDS)
def test_every_option_has_a_test_of_its_effect(label, name):
    listed = EFFECTS.get(f"{label} {name}", {})
    missing = {test for test in listed.values() if test.partition("::")[2] not in names_in(test.partition("::")[0])}

    assert set(listed) == options_of(label, name)
    assert missing == set()


def test_no_command_is_listed_that_does_not_exist():
    assert set(EFFECTS) == {f"{label} {name}" for label, name in COMMANDS}


class Bug(Exception):
    """An error that no command expects."""


@pytest.mark.parametrize(("label", "name"), COMMANDS)
def test_a_traceback_is_shown_on_request_and_never_else(monkeypatch, capsys, label, name):
    """Also that of a bug, which says that it is one."""
    found = command(label, name)

    def fail(**_):
        raise Bug("beyond\nrepair")

    monkeypatch.setattr(found, "callback", fail)
    monkeypatch.setattr(found, "params", [one for one in found.params if one.name in ("traceback", "help")])
    line = (f"{label}: Bug: beyond repair: this is a bug of {label}, not of the input; please report it with the "
            "command line, the input files and what the same command prints with --traceback\n")  # fmt: skip

    assert PROGRAMS[label].run([name]) == 70
    assert capsys.readouterr() == ("", line)
    for words in ([name, "--traceback"], ["--traceback", name]):
        assert PROGRAMS[label].run(words) == 70
        error = capsys.readouterr().err
        assert error.startswith("Traceback (most recent call last):\n")
        assert error.endswith(line)


@pytest.fixture(scope="module")
def pair(reference_fmu, tmp_path_factory):
    """Return the system file of an integrator that feeds another one."""
    source = reference_fmu("integrator", "2.0")
    parts = [Component(name=name, source=source, period=10 * MS, kind="continuous", isolated=False) for name in "ab"]
    system = System(
        name="pair",
        tick=5 * MS,
        stop_time=20 * MS,
        components=(parts[0], parts[1]),
        connections=(
            Connection(from_component="a", output="x", to_component="b", input="u", delay=2, convert_units=False),
        ),
    )
    path = tmp_path_factory.mktemp("pair") / "pair.ssd"
    write_ssd(system, path)
    return path


TIMING = {
    "--delay": "6",
    "--step-size": "a=0.02",
    "--continuous": "b",  # as it is
    "--sampled": "a",
    "--tick": "0.001",  # the file has one: refused
}


@pytest.mark.parametrize("option", TIMING)
@pytest.mark.parametrize(("label", "name"), [("lockstep", "show"), ("flexsat", "timeline")])
def test_timing_options_change_what_is_shown(pair, capsys, label, name, option):
    def shown(*options):
        code = PROGRAMS[label].run([name, str(pair), *options])
        return code, capsys.readouterr()

    (plain_code, plain), (code, given) = shown(), shown(option, TIMING[option])
    assert plain_code == 0
    if option == "--tick":
        assert (code, given.out) == (2, "")
        assert "--tick 0.001: the file has a tick of 0.005 s" in given.err
    elif option == "--continuous":
        assert (code, given.out) == (0, plain.out)
        assert shown("--sampled", "b")[1].out != given.out
    else:
        assert code == 0
        assert given.out != plain.out


def test_a_written_package_has_the_delay_and_the_step(pair, tmp_path, capsys):
    words = ["write-ssp", str(pair), "--delay", "a:b=4", "--step-size", "b=0.02", "--out", str(tmp_path / "pair.ssp")]
    assert LOCKSTEP.run(words) == 0, capsys.readouterr()
    written = load_system(tmp_path / "pair.ssp")

    assert [(one.from_component, one.delay) for one in written.connections] == [("a", 4)]
    assert {one.name: one.period for one in written.components} == {"a": 10 * MS, "b": 20 * MS}


@pytest.mark.parametrize(("option", "isolated"), [("--isolate", True), ("--share-process", False)])
def test_the_process_of_a_component_is_recorded(pair, tmp_path, capsys, option, isolated):
    words = ["run", str(pair), "--set", "a.u=1", option, "a", "--out", str(tmp_path / "out")]
    assert LOCKSTEP.run(words) == 0, capsys.readouterr()
    record = tomllib.loads((tmp_path / "out" / "run.toml").read_text(encoding="utf-8"))

    assert [part["isolated"] for part in record["component"]] == [isolated, False]


def test_a_strict_run_refuses_what_is_else_a_warning(reference_fmu, tmp_path, capsys):
    words = ["run", str(reference_fmu("integrator", "2.0")), "--stop-time", "0.01", "--out", str(tmp_path / "out")]
    assert LOCKSTEP.run([*words, "--strict"]) == 2
    assert "neither the file nor the FMU gives a step size" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
    assert LOCKSTEP.run(words) == 0


def test_a_static_check_runs_nothing(reference_fmu, capsys):
    assert LOCKSTEP.run(["check", "--static", str(reference_fmu("integrator", "2.0"))]) == 0
    shown = capsys.readouterr().out
    assert "static.archive" in shown
    assert "dynamic." not in shown


def test_options_change_what_is_probed(reference_fmu, capsys):
    fmu = str(reference_fmu("integrator", "2.0"))
    assert LOCKSTEP.run(["probe-latency", fmu, "--step-size", "0.25", "--steps", "5"]) == 0
    assert "integrator, step 0.25 s (as given), 5 steps watched" in capsys.readouterr().out


def test_results_of_two_runs_go_to_folders_of_their_own(tmp_path):
    from flexbench.runs.evaluation_folder import evaluation_folders

    runs = [tmp_path / "a", tmp_path / "b"]
    assert evaluation_folders(runs, tmp_path / "out") == [tmp_path / "out" / "a", tmp_path / "out" / "b"]
    assert evaluation_folders(runs, None) == runs
