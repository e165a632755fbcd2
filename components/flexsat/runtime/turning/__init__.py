"""Appendages that turn: the plant's matrices at other angles, and its state when an angle changes. numpy alone."""
