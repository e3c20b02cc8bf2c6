"""What `import meshcore` costs: no host, no optional library, at module level or at run time."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import meshcore

PACKAGE = Path(meshcore.__file__).parent
OPTIONAL = {"pyvista", "vtk", "vtkmodules", "meshio", "rich", "matplotlib", "bpy", "paraview", "pymeshlab"}
MODULES = sorted(p for p in PACKAGE.rglob("*.py") if "_hosts" not in p.parts and "inside" not in p.parts)


def imported_at_module_level(tree: ast.Module) -> set[str]:
    """Top-level names imported outside functions, those under TYPE_CHECKING left out."""
    found, rest = set(), list(tree.body)
    while rest:
        node = rest.pop()
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.add(node.module.split(".")[0])
        elif isinstance(node, (ast.If, ast.Try, ast.With, ast.ClassDef)):
            rest += list(ast.iter_child_nodes(node))
    return found


@pytest.mark.parametrize("path", MODULES, ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_no_module_needs_an_optional_library_or_itself_by_name(path):
    needed = imported_at_module_level(ast.parse(path.read_text(encoding="utf-8")))
    assert not needed & OPTIONAL
    assert "meshcore" not in needed, "imports inside meshcore are relative, so that it can be vendored"


def test_importing_meshcore_loads_no_optional_library():
    program = f"import sys, meshcore; print(sorted({OPTIONAL!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("path", MODULES, ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_every_file_says_in_its_first_line_what_it_is_for(path):
    assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
