"""Windows of faults, read from the events of a run."""

import json

from lockstep.faults.windows import fault_windows


def test_begin_and_end_of_a_fault_are_paired(tmp_path):
    one = {
        "event": "fault",
        "name": "one",
        "kind": "bias",
        "component": "a",
        "variables": ["u"],
        "values": {"value": 1},
    }
    two = {**one, "component": "b"}
    lines = [
        {"time": 0.0, "event": "start"},
        {**one, "time": 1.0, "state": "begin", "from": 0.9995},
        {**two, "time": 1.0, "state": "begin", "from": 0.9995},
        {**two, "time": 2.0, "state": "end"},
        {**one, "time": 3.0, "state": "begin", "from": 3.0},
        {**one, "time": 4.0, "state": "end"},
    ]
    (tmp_path / "events.jsonl").write_text("\n".join(map(json.dumps, lines)) + '\n{"time": 4.1, "ev')
    found = [(window.component, window.begin, window.end) for window in fault_windows(tmp_path)]

    assert found == [("a", 1.0, 4.0), ("b", 1.0, 2.0), ("a", 3.0, None)]
    assert fault_windows(tmp_path)[0].values == {"value": 1}
    assert fault_windows(tmp_path / "none") == []
