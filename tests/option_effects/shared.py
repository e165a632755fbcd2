"""Options that commands share."""

HERE = "flexbench/cli/test_shared_options.py"
_SHOWN = f"{HERE}::test_timing_options_change_what_is_shown"

SHOWN = dict.fromkeys(("--delay", "--step-size", "--tick", "--continuous", "--sampled"), _SHOWN)

JSON = {"--json": "lockstep/cli/test_outcome.py::test_tables_files_and_the_next_command_are_written_as_json"}
