"""The arrays of VTK's XML files: text, base64 and raw bytes, packed or not."""

from __future__ import annotations

import base64
import lzma
import re
import zlib
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..errors import InvalidInput
from .content import recognised

TYPES = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4", "Int64": "i8",
    "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
TYPE_NAMES = {dtype: name for name, dtype in TYPES.items()}
# zlib packs a thousandfold at best; what claims more is damaged.
_LARGEST_RATIO = 1100


class XmlFile:
    """A parsed file: the tree, and how its arrays are encoded."""

    def __init__(self, path: Path):
        data, appended = _without_appended(path.read_bytes())
        if not recognised(data).startswith("a VTK XML"):
            raise InvalidInput("it has no <VTKFile> at its beginning")
        if b"<!ENTITY" in data or b"<!DOCTYPE" in data:
            raise InvalidInput("it defines entities, which VTK files never do")
        try:
            self.root = ElementTree.fromstring(data)
        except ElementTree.ParseError as error:
            line, column = error.position
            raise InvalidInput(f"line {line}, column {column}: the XML is broken ({error})") from None
        self.kind = self.root.get("type", "")
        self.order = ">" if self.root.get("byte_order", "LittleEndian") == "BigEndian" else "<"
        self.header = np.dtype(self.order + TYPES.get(self.root.get("header_type", "UInt32"), "u4"))
        self.compressor = self.root.get("compressor", "")
        self.appended = appended
        element = self.root.find("AppendedData")
        self.raw = element is not None and element.get("encoding", "raw") == "raw"

    def array(self, element: ElementTree.Element) -> np.ndarray:
        """The values of a DataArray or Array, as (n,) or (n, k)."""
        name, type_name = element.get("Name", ""), element.get("type", "")
        dtype = np.dtype("i1" if type_name == "String" else TYPES.get(type_name, "V"))
        if dtype.kind == "V":
            raise InvalidInput(f"the array {name!r} is of the unknown type {type_name!r}")
        form = element.get("format", "ascii")
        if form == "ascii":
            values = _text_values(element.text or "", dtype, name)
        elif form == "binary":
            values = self._unpacked((element.text or "").encode(), dtype, name, raw=False)
        elif form == "appended":
            offset = whole_attribute(element, "offset")
            if not 0 <= offset <= len(self.appended):
                raise InvalidInput(f"the array {name!r} lies beyond the end of the file")
            values = self._unpacked(memoryview(self.appended)[offset:], dtype, name, raw=self.raw)
        else:
            raise InvalidInput(f"the array {name!r} has the unknown format {form!r}")
        if type_name == "String":
            return _strings(values)
        columns = whole_attribute(element, "NumberOfComponents", 1) or 1
        if columns < 1 or len(values) % columns:
            raise InvalidInput(f"the array {name!r} has {len(values)} values, no multiple of {columns}")
        return values.reshape(-1, columns) if columns > 1 else values

    def _unpacked(self, data: bytes | memoryview, dtype: np.dtype, name: str, *, raw: bool) -> np.ndarray:
        source = _Bytes(bytes(data) if not raw else data, raw, name)
        width = self.header.itemsize
        if not self.compressor:
            size = int(np.frombuffer(source.take(width, join=True), self.header)[0])
            content = source.take(size, after=width)
        else:
            content = self._decompressed(source, name)
        if len(content) % dtype.itemsize:
            raise InvalidInput(f"the array {name!r} is cut off")
        return np.frombuffer(content, dtype.newbyteorder(self.order)).astype(dtype)

    def _decompressed(self, source: _Bytes, name: str) -> bytes:
        """Blocks: their number, size, size of the last, and their compressed sizes, then the blocks."""
        width = self.header.itemsize
        unpack = {"vtkZLibDataCompressor": zlib.decompressobj, "vtkLZMADataCompressor": lzma.LZMADecompressor}
        if self.compressor not in unpack:
            raise InvalidInput(f"it is packed by {self.compressor!r}; write it with zlib (LZ4 is not read)")
        count, block, last = (int(n) for n in np.frombuffer(source.take(3 * width), self.header))
        if count == 0:
            return b""
        sizes = np.frombuffer(source.take(count * width, after=3 * width, join=True), self.header)
        begin, parts = (3 + count) * width, []
        for k, size in enumerate(int(n) for n in sizes):
            packed = source.take(size, after=begin)
            begin += size
            full = last if k == count - 1 and last else block
            if full > _LARGEST_RATIO * (size + 100):
                raise InvalidInput(f"the array {name!r} claims to unpack to {full} bytes from {size}")
            tool = unpack[self.compressor]()
            try:
                parts.append(tool.decompress(packed, full + 1))
            except (zlib.error, lzma.LZMAError, EOFError) as error:
                raise InvalidInput(f"the array {name!r} is damaged ({error})") from None
            if len(parts[-1]) != full:
                raise InvalidInput(f"the array {name!r} unpacks to a length that it does not promise")
        return b"".join(parts)


class _Bytes:
    """Bytes of one array, whether raw or as base64, in which header and content are encoded apart."""

    def __init__(self, data: bytes | memoryview, raw: bool, name: str):
        self.raw, self.name = raw, name
        self.data = data if raw else re.split(rb"[^A-Za-z0-9+/=\s]", data, maxsplit=1)[0].translate(None, b" \t\r\n")
        self.content: bytes | None = None
        self.header_size = 0

    def take(self, size: int, after: int = 0, join: bool = False) -> bytes:
        """``size`` bytes that begin ``after`` bytes from the start; ``join`` says that they end the header."""
        if size < 0 or size > len(self.data):
            raise InvalidInput(f"the array {self.name!r} promises more than the file holds")
        found = bytes(self.data[after : after + size]) if self.raw else self._decoded(size, after, join)
        if len(found) < size:
            raise InvalidInput(f"the array {self.name!r} is cut off")
        return found

    def _decoded(self, size: int, after: int, join: bool) -> bytes:
        if not self.header_size:
            stop = 4 * -(-(after + size) // 3)
            head = self.data[:stop]
            if join:
                self.header_size = after + size
                # VTK encodes the header apart, with its own filling, if there are blocks; else both in one run.
                apart = self.header_size % 3 == 0 or head.endswith(b"=")
                self.begin, self.skip = (stop, 0) if apart else (0, self.header_size)
            return _base64(head, self.name)[after : after + size]
        if self.content is None:  # the content is one run, up to the first filling
            tail = self.data[self.begin :]
            cut = tail.find(b"=")
            tail = tail if cut < 0 else tail[: 4 * (cut // 4 + 1)]
            self.content = _base64(tail[: len(tail) // 4 * 4], self.name)[self.skip :]
        begin = after - self.header_size
        return self.content[begin : begin + size]


def _base64(data: bytes, name: str) -> bytes:
    try:
        return base64.b64decode(data, validate=True)
    except ValueError:
        raise InvalidInput(f"the array {name!r} is no base64") from None


def _without_appended(data: bytes) -> tuple[bytes, bytes]:
    """The XML without its appended data, which may be raw bytes, and those data."""
    start = data.find(b"<AppendedData")
    if start < 0:
        return data, b""
    mark, end = data.find(b"_", data.find(b">", start)), data.rfind(b"</AppendedData>")
    if mark < 0 or end < mark:
        raise InvalidInput("the appended data have no end, so the file is cut off")
    return data[: mark + 1] + data[end:], data[mark + 1 : end]


def _text_values(text: str, dtype: np.dtype, name: str) -> np.ndarray:
    words = text.split()
    try:
        if dtype.kind == "f":
            with np.errstate(over="ignore"):
                return np.array(words, np.float64).astype(dtype)
        return np.array([int(word) for word in words], dtype)
    except (ValueError, OverflowError):
        raise InvalidInput(f"the array {name!r} holds text that is no {TYPE_NAMES[dtype.str[1:]]}") from None


def _strings(values: np.ndarray) -> np.ndarray:
    """Text, stored as bytes that end with 0."""
    parts = values.astype(np.uint8).tobytes().split(b"\0")
    return np.array([part.decode("utf-8", errors="replace") for part in parts[:-1]], dtype=str)


def whole_attribute(element: ElementTree.Element, key: str, default: int | None = None) -> int:
    """An attribute of an element as a whole number; InvalidInput if it is none and there is no default."""
    text = element.get(key)
    if text is None and default is not None:
        return default
    try:
        return int(text or "")
    except ValueError:
        raise InvalidInput(f"<{element.tag}> has {key}={text!r}, a whole number was expected") from None
