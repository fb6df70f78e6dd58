"""What a record of `--json` has that its schema does not allow."""

import json
from typing import Any

from jsonschema import Draft202012Validator

from lwr_dyn.cli.help_text import schema_file


def faults(path: str, record: Any) -> list[str]:
    """The faults of a record of the command `path`, such as "krl check", each with its place."""
    schema = json.loads(schema_file(path).read_text(encoding="utf-8"))
    return [f"{error.json_path}: {error.message}" for error in Draft202012Validator(schema).iter_errors(record)]


def disagreement(path: str, printed: str) -> list[str]:
    """What speaks against a printed record and its schema: its faults, and fields it could lack without one."""
    record = json.loads(printed)
    required = json.loads(schema_file(path).read_text(encoding="utf-8"))["required"]
    idle = [key for key in required if not faults(path, {k: v for k, v in record.items() if k != key})]
    return [*faults(path, record), *(f"{key} may lack" for key in idle)]
