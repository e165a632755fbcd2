"""Ports with units, which pythonfmu's own model description leaves out: a sampled component."""

from xml.etree.ElementTree import Element, SubElement

from pythonfmu import Fmi2Causality, Fmi2Slave, Real

UNITS = {
    "rad": {"rad": "1"},
    "deg": {"rad": "1", "factor": "0.017453292519943295"},
    "kg": {"kg": "1"},
    "K": {"K": "1"},
    "degC": {"K": "1", "offset": "273.15"},
}
PORTS = {"degrees": "deg", "mass": "kg", "celsius": "degC", "bare": "", "radians": "rad", "kelvin": "K", "free": ""}


class ToyAngle(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.degrees, self.mass, self.celsius, self.bare = 180.0, 5.0, 20.0, 1.5
        self.radians = self.kelvin = self.free = 0.0
        for name in ("degrees", "mass", "celsius", "bare"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))
        for name in ("radians", "kelvin", "free"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
            self.register_variable(Real(f"{name}_seen", causality=Fmi2Causality.output))
            setattr(self, f"{name}_seen", 0.0)

    def to_xml(self, model_options=None):
        root = super().to_xml(model_options or {})
        definitions = Element("UnitDefinitions")
        for name, base in UNITS.items():
            SubElement(SubElement(definitions, "Unit", name=name), "BaseUnit", base)
        root.insert(1, definitions)
        for variable in root.find("ModelVariables"):
            if PORTS.get(variable.get("name")):
                variable[0].set("unit", PORTS[variable.get("name")])
        return root

    def do_step(self, _current_time, _step_size):
        for name in ("radians", "kelvin", "free"):
            setattr(self, f"{name}_seen", getattr(self, name))
        return True
