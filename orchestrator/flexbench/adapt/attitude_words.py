"""Words for the quantities of attitude control, by which drafts of adapters recognise ports of foreign FMUs."""

import re

# each group names one quantity, its first word the one that flexsat uses
SYNONYMS = (
    ("rate", "gyro", "omega", "w", "angvel", "angular"),
    ("attitude", "mrp", "quaternion", "quat", "q", "att", "star", "tracker", "str"),
    ("torque", "tau", "trq", "moment"),
    ("wheel", "whl", "rw", "rwa", "mw"),
    ("speed", "n", "rpm", "encoder", "tacho"),
    ("valid", "ok", "flag", "good", "available"),
    ("acceleration", "accelerometer", "acc", "accel"),
    ("angle", "phase", "position"),
    ("command", "cmd", "ref", "reference", "target"),
)
MEASURED = frozenset({"rate", "attitude"})


def quantities(name: str) -> set[str]:
    """Return the quantities that the words of a name stand for, by the first word of each group."""
    words = {part.lower() for part in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)}
    return {group[0] for group in SYNONYMS if words & set(group)}
