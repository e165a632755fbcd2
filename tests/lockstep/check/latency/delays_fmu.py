"""Build the FMU of `delays.c`, whose delays are known, with dependencies that are right, wrong or missing."""

from collections.abc import Mapping
from pathlib import Path

from fmus.c_fmu import compile_library, pack_fmu, quoted

HERE = Path(__file__).parent
GUID = "{2f8b-delays}"
INPUTS = ("u", "v", "slow", "gated", "idle")
OUTPUTS = ("direct", "late[1]", "late[2]", "sampled", "held", "integral", "coarse", "noise")
# what each output is fed by in the same step, as it is
TRUE = {"direct": ("u",), "late[1]": (), "late[2]": (), "sampled": ("slow",), "held": ("gated", "gate"), "integral": (),
        "coarse": ("u",), "noise": ()}  # fmt: skip
DELAYS = {("direct", "u"): (0, 0), ("late[1]", "v"): (1, 1), ("late[2]", "v"): (3, 3), ("sampled", "slow"): (0, 3),
          ("held", "gated"): (0, 0), ("held", "gate"): (0, 0), ("integral", "u"): (0, 0),
          ("coarse", "u"): (0, 0)}  # fmt: skip


def build_delays(
    folder: Path,
    *defines: str,
    feeds: Mapping[str, tuple[str, ...]] | None = TRUE,
    flags: str = "",
    outputs: tuple[str, ...] = OUTPUTS[:-1],
) -> Path:
    """Compile and pack it; return its path.

    Parameters
    ----------
    defines : STATE, AT_ONCE, FIXED=0.01, CRASHES, GUARDED
    feeds : dependencies by output; None for none at all
    flags : further attributes of CoSimulation
    outputs : that the model description has; without the last, two instances are alike
    """
    library = folder / "delays.so"
    compile_library(library, [HERE / "delays.c"], defines=[quoted("GUID", GUID), *defines])
    return pack_fmu(folder / "delays.fmu", _description(feeds, flags, outputs), library)


def _description(feeds: Mapping[str, tuple[str, ...]] | None, flags: str, outputs: tuple[str, ...]) -> str:
    scalar = '<ScalarVariable name="{}" valueReference="{}" causality="{}" {}>{}</ScalarVariable>'
    real = '<Real start="{}"/>'
    variables = [scalar.format(name, i, "input", "", real.format("0.3")) for i, name in enumerate(INPUTS)]
    gate = 'variability="discrete"'
    variables.append(scalar.format("gate", 0, "input", gate, '<Boolean start="false"/>'))
    variables.append(scalar.format("scale", 5, "parameter", 'variability="fixed"', real.format("1")))
    variables += [scalar.format(name, 6 + OUTPUTS.index(name), "output", "", "<Real/>") for name in outputs]
    index = {name: str(i) for i, name in enumerate((*INPUTS, "gate", "scale", *outputs), start=1)}
    unknowns = ""
    for name in outputs:
        declared = "" if feeds is None else ' dependencies="' + " ".join(index[fed] for fed in feeds[name]) + '"'
        unknowns += f'<Unknown index="{index[name]}"{declared}/>'
    return (
        f'<fmiModelDescription fmiVersion="2.0" modelName="delays" guid="{GUID}">'
        f'<CoSimulation modelIdentifier="delays" {flags}/><DefaultExperiment stepSize="0.01"/>'
        f"<ModelVariables>{''.join(variables)}</ModelVariables>"
        f"<ModelStructure><Outputs>{unknowns}</Outputs></ModelStructure></fmiModelDescription>"
    )
