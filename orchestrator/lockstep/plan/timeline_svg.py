"""Draw a timeline: a lane for each component, a box for each step, an arrow for each read, and the routes below."""

from html import escape

from lockstep.plan.timeline import TimelineStep, routes, timeline
from lockstep.system.clock import Time, seconds_text
from lockstep.system.system import System

WIDTH, LANE, LEFT, TOP, RIGHT, LINE = 960, 78, 120, 46, 24, 18  # [px]
LONGEST = 150  # characters in a line under the figure
COLOURS = (
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#e69f00",
    "#56b4e9",
)  # Okabe and Ito: distinguishable with colour blindness


def timeline_svg(system: System, ticks: int) -> str:
    """Return the timeline of the first `ticks` ticks as an SVG image.

    A sampled step is a narrow box at the time from which its outputs hold; a continuous one spans its interval.
    Arrows leave a producer where its values begin to hold, or are true, and end where a step reads them.
    """
    steps = timeline(system, ticks)
    lanes = list(dict.fromkeys(step.component for step in steps))
    span = ticks * system.tick
    scale = (WIDTH - LEFT - RIGHT) / span
    between = routes(system)
    height = TOP + LANE * len(lanes) + 30 + LINE * len(between)
    bottom = TOP + LANE * len(lanes)

    def x(time: Time) -> float:
        return LEFT + time * scale

    colour = {name: COLOURS[number % len(COLOURS)] for number, name in enumerate(lanes)}
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif"'
        f' font-size="12" role="img" aria-label="timeline of {escape(system.name, quote=True)}">',
        f"<title>{escape(system.name)}: schedule and data exchange</title>",
        *(
            f'<marker id="tip-{number}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="6" markerHeight="6"'
            f' orient="auto"><path d="M0 0 8 4 0 8z" fill="{colour[name]}"/></marker>'
            for number, name in enumerate(lanes)
        ),
    ]
    for tick in range(ticks + 1):
        time = tick * system.tick
        parts.append(f'<line x1="{x(time):.1f}" y1="{TOP - 12}" x2="{x(time):.1f}" y2="{bottom}" stroke="#ccc"/>')
        parts.append(f'<text x="{x(time):.1f}" y="{TOP - 18}" text-anchor="middle">{seconds_text(time)} s</text>')
    width = 0.16 * system.tick * scale  # of a sampled step
    for number, name in enumerate(lanes):
        middle = TOP + LANE * number + LANE // 2
        parts.append(f'<text x="8" y="{middle + 4}" fill="{colour[name]}" font-weight="bold">{escape(name)}</text>')
    for step in steps:
        top = TOP + LANE * lanes.index(step.component) + 20
        across = (step.end - step.start) * scale - 3 if step.continuous else width
        parts.append(
            f'<rect x="{x(step.start) + 1:.1f}" y="{top}" width="{across:.1f}" height="{LANE - 40}" rx="3"'
            f' fill="{colour[step.component]}" fill-opacity="0.25" stroke="{colour[step.component]}">'
            f"<title>{escape(_step_text(step))}</title></rect>"
        )
    for step in steps:
        for read in step.reads:
            parts.append(_arrow(step, read.producer, x(read.since), x(step.start), lanes, colour[read.producer], width))
    caption = "narrow box: sampled step, its outputs hold from there; wide box: continuous step, true at its end"
    parts.append(f'<text x="{LEFT}" y="{bottom + 20}" fill="#555">{caption}</text>')
    for number, route in enumerate(between, start=1):
        parts.append(
            f'<text x="8" y="{bottom + 20 + LINE * number}" fill="{colour.get(route.producer, "#555")}">'
            f"<title>{escape(str(route))}</title>{escape(_shortened(str(route)))}</text>"
        )
    parts.append("</svg>")
    return "\n".join(parts) + "\n"


def _shortened(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 4]} ..."


def _arrow(
    step: TimelineStep, producer: str, start: float, end: float, lanes: list[str], colour: str, width: float
) -> str:
    source, target = lanes.index(producer), lanes.index(step.component)
    down = target >= source
    y1 = TOP + LANE * source + (LANE - 20 if down else 20)
    y2 = TOP + LANE * target + (20 if down else LANE - 20)
    # arrows of several producers into one step end side by side
    shift = width * (0.2 + 0.6 * source / max(1, len(lanes) - 1))
    return (
        f'<line x1="{start + shift:.1f}" y1="{y1}" x2="{end + shift:.1f}" y2="{y2}" stroke="{colour}"'
        f' stroke-width="1.3" marker-end="url(#tip-{source})"/>'
    )


def _step_text(step: TimelineStep) -> str:
    when = f"{seconds_text(step.start)} to {seconds_text(step.end)} s"
    reads = ", ".join(f"{read.count} values from {read.producer}" for read in step.reads)
    return f"{step.component}, {when}" + (f"; reads {reads}" if reads else "")
