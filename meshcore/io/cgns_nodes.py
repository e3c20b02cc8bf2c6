"""The nodes of a CGNS file in HDF5: each a group with a name, a label, a type and perhaps an array called " data".

Arrays are Fortran's in CGNS and C's in HDF5, so that their axes come in reverse: (ni, nj, nk) stands as (nk, nj, ni).

References
----------
CGNS steering committee, "CGNS/HDF5 implementation", https://cgns.github.io/standard/hdf5.html
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Union

import numpy as np

from ..errors import InvalidInput, MissingLibrary

Value = Union[str, np.ndarray, None]
NAME_LENGTH = 32
AXES = "XYZ"
"""How names of components end."""
_TYPES = {"i4": "I4", "i8": "I8", "f4": "R4", "f8": "R8", "i1": "C1", "u1": "C1", "S1": "C1", "u4": "U4", "u8": "U8"}
_DEEPEST = 24  # levels; the standard knows 9, and links may run in circles
_SIGNATURE = b"\x89HDF\r\n\x1a\n"


@dataclass
class Node:
    """One node: text, an array with its axes in reverse, or nothing, and the nodes under it."""

    name: str
    label: str
    value: Value = None
    children: list[Node] = field(default_factory=list)

    def add(self, name: str, label: str, value: Value = None) -> Node:
        """A new node under this one; its name is shortened and numbered where that is needed."""
        child = Node(unique(name, {node.name for node in self.children}), label, value)
        self.children.append(child)
        return child

    def of(self, label: str) -> Iterator[Node]:
        """The nodes under this one with a label."""
        return (child for child in self.children if child.label == label)

    def find(self, name: str) -> Node | None:
        """The node of this name under this one."""
        return next((child for child in self.children if child.name == name), None)

    def need(self, name: str) -> Node:
        """The node of this name under this one, or `InvalidInput`."""
        child = self.find(name)
        if child is None:
            raise InvalidInput(f"{self.label} {self.name!r} lacks {name}")
        return child

    def text(self) -> str:
        """The value as text."""
        if not isinstance(self.value, str):
            raise InvalidInput(f"{self.label} {self.name!r} needs text")
        return self.value

    def whole(self, *shape: int) -> np.ndarray:
        """The value as whole numbers of a shape, in which -1 is any."""
        if not isinstance(self.value, np.ndarray) or self.value.dtype.kind not in "iu":
            raise InvalidInput(f"{self.label} {self.name!r} needs whole numbers")
        found = self.value.shape
        if len(found) != len(shape) or any(a not in (-1, b) for a, b in zip(shape, found, strict=True)):
            raise InvalidInput(f"{self.label} {self.name!r} has shape {found[::-1]}, {shape[::-1]} was expected")
        return self.value.astype(np.int64)


def unique(name: str, taken: set[str]) -> str:
    """A name that a node may have, of at most 32 bytes, without slashes, and that is not taken.

    Examples
    --------
    >>> unique("wall/upper", {"wall_upper"})
    'wall_upper 2'
    """
    plain = " ".join(name.replace("/", "_").replace("\0", "").split()) or "unnamed"
    plain = "_" if plain in (".", "..") else plain
    number, ending = 1, ""
    while True:
        kept = plain.encode()[: NAME_LENGTH - len(ending)].decode(errors="ignore").rstrip() + ending
        if kept not in taken:
            return kept
        number += 1
        ending = f" {number}"


def _h5py() -> Any:
    try:
        import h5py
    except ImportError:
        raise MissingLibrary("h5py", "reading and writing CGNS files") from None
    return h5py


# ---- writing


def write_nodes(path: Path, nodes: list[Node]) -> None:
    """A file with these nodes under its root."""
    h5py = _h5py()
    with h5py.File(path, "w", libver=("earliest", "v110"), track_order=True) as file:
        _set_text(h5py, file, "name", "HDF5 MotherNode", NAME_LENGTH + 1)
        _set_text(h5py, file, "label", "Root Node of HDF5 File", NAME_LENGTH + 1)
        _set_text(h5py, file, "type", "MT", 3)
        version = f"HDF5 Version {h5py.version.hdf5_version}"
        file.create_dataset(" format", data=_characters("IEEE_LITTLE_32\0"))
        file.create_dataset(" hdf5version", data=_characters(version.ljust(NAME_LENGTH + 1, "\0")))
        for node in nodes:
            _write_node(h5py, file, node)


def _write_node(h5py: Any, parent: Any, node: Node) -> None:
    group = parent.create_group(node.name, track_order=True)
    value = _characters(node.value) if isinstance(node.value, str) else node.value
    kind = "MT" if value is None else "C1" if value.dtype.kind in "S" else _TYPES[value.dtype.str[1:]]
    _set_text(h5py, group, "name", node.name, NAME_LENGTH + 1)
    _set_text(h5py, group, "label", node.label, NAME_LENGTH + 1)
    _set_text(h5py, group, "type", kind, 3)
    group.attrs.create("flags", np.array([1], np.int32))
    if value is not None:
        group.create_dataset(" data", data=np.ascontiguousarray(value))
    for child in node.children:
        _write_node(h5py, group, child)


def _set_text(h5py: Any, group: Any, name: str, text: str, size: int) -> None:
    """An attribute of fixed length, ended by a zero, as CGNS's library writes it."""
    kind = h5py.h5t.C_S1.copy()
    kind.set_size(size)
    attribute = h5py.h5a.create(group.id, name.encode(), kind, h5py.h5s.create(h5py.h5s.SCALAR))
    attribute.write(np.array(text.encode(), f"S{size}"))


def _characters(text: str) -> np.ndarray:
    return np.frombuffer(text.encode(), np.int8)


# ---- reading


def read_nodes(path: Path) -> Node:
    """The root of a file, and all under it.

    Raises
    ------
    InvalidInput
        If it is no HDF5 file, is cut off, or its links lead nowhere.
    """
    with open(path, "rb") as file:
        head = file.read(64)
    if b"ADF Database" in head:
        raise InvalidInput("it is CGNS in the old ADF form; convert it with adf2hdf of CGNS's tools")
    if not head.startswith(_SIGNATURE):
        raise InvalidInput("it is no HDF5 file")
    h5py = _h5py()
    try:
        with h5py.File(path, "r") as file:
            return _read_node(h5py, file, "/", 0)
    except (OSError, KeyError, RuntimeError, ValueError) as error:
        what = str(error).split("\n")[0][:200]
        raise InvalidInput(f"it is damaged, or one of its links leads nowhere, such as to a file ({what})") from None


def _read_node(h5py: Any, group: Any, name: str, depth: int) -> Node:
    if depth > _DEEPEST:
        raise InvalidInput(f"{name!r} lies {depth} levels deep; its links run in circles")
    kind = _text(group.attrs.get("type", ""))
    node = Node(_text(group.attrs.get("name", name)), _text(group.attrs.get("label", "")))
    if kind == "LK":  # it stands for a node elsewhere in this file or in another, under its own name
        target = _read_node(h5py, group[" link"], name, depth + 1)
        return Node(node.name, target.label, target.value, target.children)
    for key in _in_order(h5py, group):
        inner = group[key]
        if key == " data" and isinstance(inner, h5py.Dataset) and kind != "MT":
            node.value = _value(inner[()], kind)
        elif isinstance(inner, h5py.Group) and not key.startswith(" "):
            node.children.append(_read_node(h5py, inner, key, depth + 1))
    return node


def _in_order(h5py: Any, group: Any) -> list[str]:
    """Names of a group's members as they were made, or else by name."""
    tracked = group.id.get_create_plist().get_link_creation_order() & h5py.h5p.CRT_ORDER_TRACKED
    if not tracked:
        return list(group)
    names: list[bytes] = []
    group.id.links.iterate(names.append, idx_type=h5py.h5.INDEX_CRT_ORDER)
    return [name.decode() for name in names]


def _value(array: np.ndarray, kind: str) -> Value:
    if kind == "C1" and array.ndim == 1:
        return array.astype(np.int8).tobytes().decode(errors="replace").rstrip(" \0")
    if array.dtype.kind not in "iuf":
        raise InvalidInput(f"an array holds {array.dtype}, which is no number of CGNS")
    return array


def _text(value: Any) -> str:
    return value.decode(errors="replace").rstrip(" \0") if isinstance(value, bytes) else str(value)
