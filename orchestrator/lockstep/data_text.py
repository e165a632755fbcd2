"""Parse the text of data files, TOML and JSON, or refuse it in one line."""

import json
import tomllib
from typing import Any

from lockstep.errors import InputError


def parse_toml(content: bytes | str, where: str, remedy: str = "") -> dict[str, Any]:
    """Return the tables of a TOML file, or raise InputError. `where` names it, `remedy` ends the message."""
    try:
        return tomllib.loads(content if isinstance(content, str) else content.decode("utf-8"))
    except ValueError as error:  # no UTF-8, or no TOML
        raise InputError(f"{where}: is no TOML ({error}){_then(remedy)}") from None
    except RecursionError:
        raise InputError(f"{where}: is nested too deeply to be read{_then(remedy)}") from None


def parse_json(content: bytes | str, where: str, remedy: str = "") -> Any:
    """Return the content of a JSON file, or raise InputError. `where` names it, `remedy` ends the message."""
    try:
        return json.loads(content if isinstance(content, str) else content.decode("utf-8"))
    except ValueError as error:  # no UTF-8, or no JSON
        raise InputError(f"{where}: is no JSON ({error}){_then(remedy)}") from None
    except RecursionError:
        raise InputError(f"{where}: is nested too deeply to be read{_then(remedy)}") from None


def _then(remedy: str) -> str:
    return f"; {remedy}" if remedy else ""
