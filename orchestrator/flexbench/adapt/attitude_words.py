"""Words for the quantities of attitude control, by which drafts of adapters recognise ports of foreign FMUs."""

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
