"""Bars of where the wall time went, and of how late ticks began."""

from flexbench.figures.drawing import save_figure
from flexbench.figures.profile import profile_figure

TIME = {
    "loop": 4.0, "real_time_factor": 25.0, "exchange": 0.5, "recording": 0.25, "waiting": 0.0, "rest": 0.25,
    "component": [{"name": "plant", "calls": 1000, "time": 2.0, "step": 0.002},
                  {"name": "controller", "calls": 200, "time": 1.0, "step": 0.005}],
}  # fmt: skip
PACE = {
    "factor": 1.0, "overruns": 3, "worst_lateness": 0.0021, "worst_at": 0.5,
    "lateness_edges": [1e-6, 1e-3, 1.0], "lateness_counts": [10, 5, 2, 1],
}  # fmt: skip


def bars(axes):
    names = [label.get_text() for label in axes.get_yticklabels()]
    return dict(zip(names, [bar.get_width() for bar in axes.patches], strict=True))


def test_every_part_has_its_bar(tmp_path):
    figure = profile_figure({"time": TIME})
    (axes,) = figure.axes
    assert bars(axes) == {
        "plant (1000 steps)": 2.0, "controller (200 steps)": 1.0, "exchange": 0.5, "recording": 0.25, "waiting": 0.0,
        "rest": 0.25,
    }  # fmt: skip
    assert [text.get_text() for text in axes.texts][:2] == [" 50.0 %", " 25.0 %"]
    assert [path.name for path in save_figure(figure, tmp_path, "profile")] == ["profile.png", "profile.svg"]


def test_a_paced_run_has_its_latenesses():
    axes = profile_figure({"time": TIME, "pace": PACE}).axes[1]
    assert bars(axes) == {"to 1 us": 10, "1 ms": 5, "1 s": 2, "over 1 s": 1}
    assert axes.get_title(loc="left") == "paced at 1 x real time: 3 overruns, worst 2.1 ms late"


def test_a_run_in_python_that_was_not_measured_has_its_calls():
    time = {"loop": 4.0, "real_time_factor": 25.0, "component": [{"name": "plant", "calls": 1000}]}
    assert bars(profile_figure({"time": time}).axes[0]) == {"plant (1000 steps)": 0.0}
