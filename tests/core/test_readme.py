"""The README's generated tables are what the registry and the formats say; `make registry` writes them anew."""

import re
from pathlib import Path

import numpy as np

import meshcore
from meshcore import gallery

README = Path(__file__).resolve().parent.parent.parent / "README.md"


def operations_table() -> str:
    """One row an operation."""
    rows = ["| operation | what it does | survey | kind |", "| --- | --- | --- | --- |"]
    for name, op in meshcore.operations().items():
        survey = re.search(r"[Ss]urvey,? sections? ([\d., and]+\d)", op.function.__doc__)
        assert survey, f'{name}: the References of its docstring name no section, as in "Survey, section 2.4.1."'
        rows.append(f"| `{name}` | {op.summary} | {survey.group(1)} | {op.category} |")
    return "\n".join(rows)


def with_tables(text: str) -> str:
    """The README with its generated parts as they should be."""
    block = f"<!-- operations -->\n{operations_table()}\n<!-- /operations -->"
    return re.sub(r"<!-- operations -->.*<!-- /operations -->", lambda _: block, text, flags=re.S)


def test_the_table_of_operations_is_up_to_date():
    text = README.read_text()
    assert "<!-- operations -->" in text
    assert with_tables(text) == text


def test_the_python_examples_run_as_they_stand(tmp_path, monkeypatch, capsys):
    examples = re.findall(r"```python\n(.*?)```", README.read_text(), flags=re.S)
    monkeypatch.chdir(tmp_path)
    meshcore.io.write("rae2822.dat", gallery.airfoil("rae2822"))
    names = {}
    exec("\n".join(examples), names)
    assert names["finer"].n_cells > names["mesh"].n_cells
    assert meshcore.io.read("section.vtu").n_cells == names["mesh"].n_cells
    region, corners = names["tagged"].cell_data["region"], names["tagged"].points[names["tagged"].get("triangle")]
    areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert set(region) == {7, 8} and areas[region == 7].max() <= 1e-3 < areas[region == 8].max()
    assert len(names["fine"].cells["triangle"]) > len(names["exact"].cells["triangle"])
    assert "Delaunay Refinement" in capsys.readouterr().out


def test_every_linked_file_is_there():
    for target in re.findall(r"\]\(([^)#]+)\)", README.read_text()):
        assert target.startswith("http") or (README.parent / target).exists(), target


if __name__ == "__main__":
    README.write_text(with_tables(README.read_text()))
