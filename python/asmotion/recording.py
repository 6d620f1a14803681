"""Recordings of ports, as `asmotion run --record FILE.csv` writes them."""

from __future__ import annotations

import csv
import json
import os
from typing import Any

from asmotion.types import Boolean, Choice, Elements, Form, Optional, Real, RecordForm, Text, Whole


def read(file: str | os.PathLike[str], name: str, form: Form) -> list[tuple[int, Any]]:
    """Returns the samples of a port, `Component.port`, with their times in ns.

    Raises:
        LookupError: the recording has no such port; with those that it has.
        ValueError: the file is no recording, or lacks elements of a long list.
        MismatchError: the samples do not fit the type.
    """
    with open(file, newline="", encoding="utf-8") as text:
        rows = csv.reader(text)
        head = next(rows, [])
        if not head or head[0] != "time_s":
            raise ValueError(f"`{os.fspath(file)}` is no recording of `asmotion run --record`")
        columns = _columns(head, name)
        samples = []
        for row in rows:
            cells = {path: row[index] for index, path in columns.items() if row[index] != ""}
            if cells:
                seconds, _, rest = row[0].partition(".")
                now = int(seconds) * 1_000_000_000 + int(rest.ljust(9, "0"))
                samples.append((now, form.load(_value(form, _tree(cells)))))
    return samples


def _columns(head: list[str], name: str) -> dict[int, tuple[str, ...]]:
    """Returns the columns of a port with their paths in its samples."""
    found: dict[int, tuple[str, ...]] = {}
    for index, column in enumerate(head):
        if column == name:  # samples without parts
            found[index] = ()
        elif column.startswith(f"{name}."):
            found[index] = tuple(column[len(name) + 1 :].split("."))
    if not found:
        ports = sorted({".".join(column.split(".")[:2]) for column in head[1:]})
        raise LookupError(f"the recording has no port `{name}`; it has {', '.join(f'`{port}`' for port in ports) or 'none'}")
    siblings = {path[:-1] for path in found.values() if path and path[-1].isdigit()}
    for path in found.values():
        if len(path) > 1 and path[-1] == "count" and path[:-1] not in siblings:
            raise ValueError(f"of long lists such as `{'.'.join(path[:-1])}` of `{name}`, only the length is recorded")
    return found


def _tree(cells: dict[tuple[str, ...], str]) -> Any:
    if () in cells:
        return cells[()]
    tree: dict[str, Any] = {}
    for path, cell in cells.items():
        here = tree
        for part in path[:-1]:
            here = here.setdefault(part, {})
        here[path[-1]] = cell
    return tree


def _value(form: Form, tree: Any) -> Any:
    """Returns cells as data of a type."""
    if isinstance(form, RecordForm) and isinstance(tree, dict):
        fields = form.by_name
        return {name: _value(fields[name].form if name in fields else Form(), part) for name, part in tree.items()}
    if isinstance(form, Elements) and isinstance(tree, dict):
        return [_value(form.element, tree[index]) for index in sorted(tree, key=int)]
    if isinstance(form, Optional):
        return None if tree == "null" else _value(form.some, tree)
    if isinstance(tree, dict):
        if all(name.isdigit() for name in tree):
            return [_value(Form(), tree[index]) for index in sorted(tree, key=int)]
        return {name: _value(Form(), part) for name, part in tree.items()}
    if isinstance(form, (Text, Choice)):
        return tree
    if isinstance(form, Boolean):
        return {"true": True, "false": False}.get(tree, tree)
    if isinstance(form, (Whole, Real)):
        return _number(form, tree)
    try:
        return json.loads(tree)
    except ValueError:
        return tree


def _number(form: Form, cell: str) -> Any:
    try:
        return int(cell) if isinstance(form, Whole) else float(cell)
    except ValueError:
        return cell  # which the form refuses
