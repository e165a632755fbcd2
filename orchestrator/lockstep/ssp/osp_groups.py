"""Read the variable groups of an OspModelDescription.xml, and pair the variables of two connected groups."""

from lockstep.errors import InputError, compact
from lockstep.fmi.model_description import Description
from lockstep.ssp.documents.location import Location
from lockstep.ssp.documents.parse import secure_root
from lockstep.ssp.documents.xml import Element
from lockstep.system.component import Component

_Owner = tuple[Component, Description]


def group_pairs(
    first: _Owner, second: _Owner, ends: tuple[str, str], other: tuple[str, str], location: Location
) -> list[tuple[str, str]]:
    """Return the pairs of variables of two groups, in the order in which both list them. Raises InputError."""
    one, two = group_variables(first, ends[1], location), group_variables(second, other[1], location)
    if len(one) != len(two):
        what = f"{ends[0]}.{ends[1]} -> {other[0]}.{other[1]}"
        raise InputError(f"{what}: groups of {len(one)} and {len(two)} variables; they must have the same")
    return list(zip(one, two, strict=True))


def group_variables(owner: _Owner, name: str, location: Location) -> list[str]:
    """Return the variables of a group of an FMU, in the order in which it lists them. Raises InputError."""
    component, description = owner
    file = f"{description.model}_OspModelDescription.xml"
    for folder in (component.source.parent, location.document.parent):
        if (folder / file).is_file():
            root = secure_root((folder / file).read_bytes(), str(folder / file))
            # the namespace counts versions, and libcosim reads them all alike
            groups = [e for e in root.iterfind("{*}VariableGroups//*") if e.get("name") is not None]
            return _flat(groups, name, f"{component.name}: {folder / file}")
    raise InputError(f"{component.name}: no {file} beside its FMU or the system file, which has to define {name}")


def _flat(groups: list[Element], name: str, where: str) -> list[str]:
    for group in groups:
        if group.get("name") == name:
            return [str(v.get("ref")) for v in group.iter("{*}Variable")]
    raise InputError(f"{where}: no group {name}; there are {compact(str(g.get('name')) for g in groups)}")
