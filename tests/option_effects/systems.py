"""Tests of the options of what is built, written and shown: spacecraft, FMUs, systems, bundles."""

from .shared import HERE, JSON, SHOWN

_SPACECRAFT = "flexbench/cli/spacecraft/test_spacecraft.py::"
_SSP = "system/test_write_ssp.py::test_the_loop_is_that_with_the_adapter"
_ADAPTED = "lockstep/ssp/test_adapted_package.py::"
_BUILT = "flexsat/fmu/test_built_components.py::"
_SAME_BYTES = _BUILT + "test_builds_in_another_process_and_folder_and_on_another_processor_give_equal_bytes"
_EXPORTED_C = "flexbench/cli/test_export_c.py::test_every_option_changes_what_is_written"
_SHOWN_AS_JSON = {"--json": f"{HERE}::test_what_is_shown_is_json_too"}
_BUNDLE = "lockstep/bundle/test_command.py::test_"

WRITE_SSP = dict.fromkeys(("--replace", "--adapter", "--source", "--out"), _SSP) | {
    **dict.fromkeys(("--delay", "--step-size"), f"{HERE}::test_a_written_package_has_the_delay_and_the_step"),
    "--partial": _ADAPTED + "test_entry_without_a_connection_is_listed_and_refused_or_left_out",
}

EFFECTS = {
    "flexsat build": {
        "--configuration": "flexbench/loop/test_build.py::test_building_one_configuration_keeps_the_unchanged_other",
        **dict.fromkeys(("--out", "--flat"), _SAME_BYTES),
        "--missions": "system/test_missions.py::test_the_short_day",
        "--no-native": "flexsat/fmu/native/test_native_components.py::test_each_layout_has_them_beside_the_others",
        "--fmi3": "flexbench/loop/test_build.py::test_fmus_of_fmi_3_have_a_folder_with_systems_in_the_manifest",
        "--platforms": "flexbench/cli/test_build_platforms.py::test_each_platform_is_built_once_in_the_usual_order",
        "--needs-execution-tool": "flexsat/fmu/test_export.py::test_a_build_declares_that_a_tool_is_needed_if_asked_to",
    },
    "flexsat new": {},
    "flexsat modal": {
        "--json": "flexbench/cli/spacecraft/test_modal.py::test_tables_become_a_modal_file",
        "--out": "flexbench/cli/spacecraft/test_modal.py::test_tables_become_a_modal_file",
        "--nastran-python": "flexbench/cli/spacecraft/test_nastran.py::"
                            "test_participation_and_mass_are_those_of_the_models_mass_matrix",
    },
    "flexsat spacecraft": JSON
    | {
        "--file": _SPACECRAFT + "test_the_file_of_a_built_in_spacecraft_is_one_to_start_from",
        "--list-modes": _SPACECRAFT + "test_the_start_is_shown",
        "--schema": _SPACECRAFT + "test_the_schema_is_the_page_of_the_documentation",
        "--draw": _SPACECRAFT + "test_a_spacecraft_is_drawn",
    },
    "flexsat export-c": dict.fromkeys(("--configuration", "--design", "--precision", "--out", "--fmus"), _EXPORTED_C),
    **dict.fromkeys(("lockstep bundle", "flexsat bundle"), dict.fromkeys(
        ("--out", "--input", "--output", "--parameter", "--multiple-of", "--fmi3", "--set", *SHOWN),
        _BUNDLE + "every_option_changes_the_bundle",
    ) | {"--platforms": _BUNDLE + "zig_builds_for_chosen_platforms_that_all_fmus_have"}),
    **dict.fromkeys(("lockstep write-ssp", "flexsat write-ssp"), WRITE_SSP),
    "lockstep show": SHOWN | _SHOWN_AS_JSON,
    "flexsat timeline": SHOWN | _SHOWN_AS_JSON
    | dict.fromkeys(("--ticks", "--svg"), "system/test_foreign_package.py::test_the_command_shows_and_draws_it"),
}  # fmt: skip
