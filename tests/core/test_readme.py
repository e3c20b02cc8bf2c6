"""The README's generated tables are what the registry and the formats say; `make registry` writes them anew."""

import re
from pathlib import Path

import meshcore

README = Path(__file__).resolve().parent.parent.parent / "README.md"


def operations_table() -> str:
    """One row an operation."""
    rows = ["| operation | what it does | survey | kind |", "| --- | --- | --- | --- |"]
    for name, op in meshcore.operations().items():
        survey = re.search(r"[Ss]urvey,? sections? ([\d., and]+\d)", op.function.__doc__)
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


def test_every_linked_file_is_there():
    for target in re.findall(r"\]\(([^)#]+)\)", README.read_text()):
        assert target.startswith("http") or (README.parent / target).exists(), target


if __name__ == "__main__":
    README.write_text(with_tables(README.read_text()))
