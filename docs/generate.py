"""Pages that are written rather than kept: operations from the registry, the gallery from the examples.

``python docs/generate.py`` draws the pictures of the README anew, which are kept.
"""

from __future__ import annotations

import ast
import contextlib
import io
import runpy
from pathlib import Path

import meshcore
from meshcore import demo
from meshcore import gallery as models
from meshcore.operation import Operation, Param
from meshcore.picture import picture

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def write_all(source: Path) -> None:
    """Write all generated pages below the documentation's source folder."""
    reference = source / "reference" / "generated"
    reference.mkdir(parents=True, exist_ok=True)
    (reference / "operations.rst").write_text(operations_page())
    gallery = source / "gallery"
    gallery.mkdir(exist_ok=True)
    (gallery / "index.rst").write_text(gallery_page(gallery))


def heading(text: str, line: str) -> str:
    """A heading of reStructuredText."""
    return f"{text}\n{line * len(text)}\n"


def operations_page() -> str:
    """Every registered operation: inputs, parameters with limits and units, and how it is called in each host."""
    parts = [
        heading("Operations", "="),
        "Every operation is a Python function, a subcommand of ``meshcore``, an operator in Blender, a source\n"
        "or filter in ParaView and a function for MeshLab, with the same parameters. This page is made from the\n"
        "registry. In hosts, 0 stands for a number that is optional in Python.\n",
    ]
    for operation in meshcore.operations().values():
        parts.append(_operation(operation))
    return "\n".join(parts)


def _operation(operation: Operation) -> str:
    rows = [("Parameter", "Type", "Default", "Limits", "Meaning")]
    for param in operation.params.values():
        rows.append((f"``{param.name}``", _kind(param), _default(param), _limits(param), param.description))
    flag = operation.id.replace("_", "-")
    inputs = [
        f"* ``{port.name}``{' (optional)' if port.optional else ''}: {port.description}"
        for port in operation.inputs.values()
    ]
    words = [flag] + [f"[{p.name.upper()}]" if p.optional else p.name.upper() for p in operation.inputs.values()]
    table = "\n".join("   * - " + "\n     - ".join(cell or "\\" for cell in row) for row in rows)
    return "\n".join(
        [
            heading(operation.label, "-"),
            f"{operation.summary} Category {operation.category}; makes a {operation.output}.\n",
            f":Python: :func:`meshcore.{operation.id}`",
            f":Command line: ``meshcore {' '.join(words)} -o OUTPUT``, see ``meshcore {flag} --help``",
            f":Menus: {operation.label}, in Blender and ParaView\n",
            *(["Inputs\n", *inputs, ""] if inputs else []),
            *([".. list-table::\n   :header-rows: 1\n", table, ""] if operation.params else []),
        ]
    )


def _kind(param: Param) -> str:
    kind = "one of " + ", ".join(param.choices) if param.choices else param.kind
    return f"{param.size} {kind}" if param.size > 1 else kind


def _default(param: Param) -> str:
    return "none" if param.default is None else f"``{param.default}``" if param.default != "" else "none"


def _limits(param: Param) -> str:
    low = "" if param.min is None else f"from {param.min:g}"
    high = "" if param.max is None else f"to {param.max:g}"
    return " ".join(part for part in (low, high, param.unit) if part)


def gallery_page(folder: Path) -> str:
    """Run every example, and show its pictures with its code."""
    parts = [
        heading("Gallery", "="),
        "The figures of the survey that meshcore can draw so far, and tasks from practice. Every script also asserts\n"
        "a fact about what it draws, and runs in the tests.\n",
    ]
    for script in sorted(EXAMPLES.glob("*.py"), key=lambda path: (not path.name.startswith("figure"), path.name)):
        title, text = _docstring(script)
        pictures = folder / script.stem
        with contextlib.redirect_stdout(io.StringIO()):  # some examples print tables
            runpy.run_path(str(script))["main"](pictures)
        parts += [heading(title, "-"), text, ""]
        for drawn in sorted(pictures.glob("*.png")):
            parts.append(f".. image:: {script.stem}/{drawn.name}\n   :width: 100%\n   :alt: {title}\n")
        parts.append(f".. literalinclude:: ../../examples/{script.name}\n   :language: python\n")
    return "\n".join(parts)


def _docstring(script: Path) -> tuple[str, str]:
    """Title and text of a script's docstring."""
    title, _, text = (ast.get_docstring(ast.parse(script.read_text())) or script.stem).partition("\n")
    return title.rstrip("."), text.strip() + "\n"


def write_readme_pictures(folder: Path) -> None:
    """The three meshes of the demo, small, for the README."""
    section = models.airfoil("rae2822")
    triangles = demo.triangulation(section).mesh
    near, size = ((-0.2, -0.45), (1.2, 0.6)), (640, 480)
    picture(triangles, folder / "triangles.png", zoom=near, window=size)
    picture(demo.block(section, cells=160).mesh, folder / "o_grid.png", zoom=near, window=size)
    picture(demo.adapted(triangles).mesh, folder / "adapted.png", scalars="shock", zoom=near, window=size)


if __name__ == "__main__":
    write_readme_pictures(Path(__file__).parent / "pictures")
