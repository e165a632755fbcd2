"""Options that commands share."""

HERE = "flexbench/cli/test_shared_options.py"
_SHOWN = f"{HERE}::test_timing_options_change_what_is_shown"

SHOWN = dict.fromkeys(("--delay", "--step-size", "--tick", "--continuous", "--sampled"), _SHOWN)
