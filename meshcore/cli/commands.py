"""Commands on files: one per operation, and list, quality, convert, warmup, demo."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..mesh import MultiBlock, PolyhedralMesh
from ..operation import Operation, operations
from . import files, flags, terminal

Inputs = dict[str, Any]
"""What was read from files by the names of the inputs, so that an error can tell where it lies."""

NO_FILE = "-"
"""In the place of an input that may be left out."""

BESIDE = Path(".png")
"""A picture without a name: it gets the output's."""

Run = Callable[[argparse.Namespace, Inputs], "int | None"]


def add_command(subparsers: Any, name: str, run: Run, help: str, epilog: str = "") -> argparse.ArgumentParser:
    """A subcommand with the flags that all have."""
    command = subparsers.add_parser(
        name,
        help=flags.escaped(help),
        description=help,
        epilog=epilog,
        allow_abbrev=False,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument("--json", action="store_true", help="print JSON, for scripts")
    command.add_argument("--quiet", action="store_true", help="no progress bar and no report")
    command.add_argument("--debug", action="store_true", help="show the traceback of an error")
    command.set_defaults(run=run)
    return command


def add_operation(subparsers: Any, operation: Operation) -> None:
    """The subcommand of an operation: a file an input, a flag a parameter."""
    name = operation.id.replace("_", "-")
    command = add_command(subparsers, name, run_operation, operation.summary, flags.example(operation))
    command.set_defaults(operation=operation)
    for port in operation.inputs.values():
        if port.named:
            help = flags.escaped(port.description) + " (may be left out)"
            command.add_argument(f"--{port.name.replace('_', '-')}", type=Path, metavar="FILE", help=help)
            continue
        last = port.name == [other.name for other in operation.inputs.values() if not other.named][-1]
        left_out = " (may be left out)" if last else f" (may be left out; {NO_FILE} in its place where others follow)"
        help = flags.escaped(port.description) + (left_out if port.optional else "")
        command.add_argument(port.name, type=Path, nargs="?" if port.optional else None, help=help)
    command.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help="where the mesh goes")
    command.add_argument(
        "--picture",
        type=Path,
        nargs="?",
        const=BESIDE,
        metavar="PNG",
        help="draw the mesh, too; without a name beside the output, with .png as its extension",
    )
    command.add_argument("--histogram", action="store_true", help="print the quality of the cells, with histograms")
    flags.add_params(command, operation)


def add_file_commands(subparsers: Any) -> None:
    """Commands on files and on meshcore itself."""
    add_command(subparsers, "list", run_list, "List the operations and the file formats.")

    command = add_command(subparsers, "quality", run_quality, "Measure the cells of a mesh.")
    command.add_argument("mesh", type=Path, help="file of a mesh or a structured grid")
    command.add_argument(
        "--measure",
        action="append",
        metavar="NAME",
        help="a measure by name, such as min_angle; may be given several times",
    )
    command.add_argument("--histogram", action="store_true", help="print a histogram of each measure")
    command.add_argument("--picture", type=Path, metavar="PNG", help="draw the mesh, coloured by the first measure")
    command.add_argument(
        "--pictures", type=Path, metavar="FOLDER", help="draw the mesh once for each measure of the table, by name"
    )

    command = add_command(subparsers, "convert", run_convert, "Read a mesh in one format and write it in another.")
    command.add_argument("input", type=Path, help="file to read")
    command.add_argument("output", type=Path, help="file to write; its extension is the format")

    add_command(subparsers, "warmup", run_warmup, "Compile all kernels ahead, so that no first call has to wait.")

    command = add_command(subparsers, "demo", run_demo, "Mesh a real airfoil three ways, with pictures.")
    command.add_argument("folder", type=Path, nargs="?", default=Path("meshcore-demo"), help="default: meshcore-demo")


def run_operation(arguments: argparse.Namespace, inputs: Inputs) -> None:
    """Read, call, write, draw, report."""
    operation: Operation = arguments.operation
    values = flags.values(arguments, operation)
    paths = {name: getattr(arguments, name) for name in operation.inputs}
    paths = {name: path for name, path in paths.items() if path not in (None, Path(NO_FILE))}
    if arguments.picture == BESIDE:
        arguments.picture = arguments.output.with_suffix(BESIDE.name)
    files.check_names([arguments.output, arguments.picture], paths.values())
    if operation.output != "as given":
        files.check_mesh_file(arguments.output, operation.output)
    files.check_picture_file(arguments.picture)
    with terminal.progress_bar(arguments.quiet) as bar:
        bar(0.0, "reading")
        for name, path in paths.items():
            inputs[name] = files.read(path, operation.inputs[name].type)
        if operation.output == "as given":
            files.check_mesh_file(arguments.output, files.kind_of(next(iter(inputs.values()))))
        bar(0.0, "compiling")  # what a first call does for seconds; the operation's own words follow
        mesh, report = operation.function(**inputs, **values, progress=bar)
        bar(1.0, "writing")
        written, told = files.write(arguments.output, mesh, operation.output)
        report = replace(report, warnings=[*report.warnings, *told])
        if arguments.picture:
            files.draw(mesh, arguments.picture, title=operation.label)
    if arguments.json:
        files.print_json({**vars(report), "output": str(written), "picture": arguments.picture})
    elif not arguments.quiet:
        print(report)
        if arguments.histogram:
            from .. import quality

            cells = mesh.to_mesh() if operation.output == "polyhedra" else mesh
            for block in cells.blocks if isinstance(cells, MultiBlock) else (cells,):
                print(f"\n{quality.report(block)}")


def run_list(arguments: argparse.Namespace, inputs: Inputs) -> None:
    """The tables of operations and of formats."""
    from .. import io

    if arguments.json:
        declared = {name: operation.declaration() for name, operation in operations().items()}
        files.print_json({"operations": declared, "formats": [row._asdict() for row in io.formats()]})
        return
    rows = [(name.replace("_", "-"), op.category, op.output, op.summary) for name, op in operations().items()]
    print(terminal.table(rows, header=("operation", "category", "makes", "what it does")))
    print()
    marks = [(row, "read" * row.reads, "write" * row.writes) for row in io.formats()]
    formats = [(row.extensions, row.name, reads, writes, row.description) for row, reads, writes in marks]
    print(terminal.table(formats, header=("extension", "format", "", "", "")))


def run_quality(arguments: argparse.Namespace, inputs: Inputs) -> None:
    """Measures of a file's cells: a table, histograms, a picture."""
    from .. import quality

    files.check_names([arguments.picture], [arguments.mesh])
    files.check_picture_file(arguments.picture)
    files.check_folder(arguments.pictures)
    mesh = files.read(arguments.mesh)
    inputs["mesh"] = mesh
    if isinstance(mesh, PolyhedralMesh):
        mesh = mesh.to_mesh()  # measures are of triangles and tetrahedra
    blocks = dict(zip(mesh.names, mesh.blocks, strict=True)) if isinstance(mesh, MultiBlock) else {"": mesh}
    reports = {name: quality.report(block, arguments.measure) for name, block in blocks.items()}
    if arguments.picture:
        colour = next(iter(next(iter(reports.values())).rows), None)
        files.draw(mesh, arguments.picture, scalars=colour, title=arguments.mesh.name)
    if arguments.pictures:
        for measure in next(iter(reports.values())).rows:
            if not all(measure in report.rows for report in reports.values()):
                continue
            path = arguments.pictures / f"{measure}.png"
            files.draw(mesh, path, scalars=measure, title=f"{arguments.mesh.name}: {measure.replace('_', ' ')}")
    if arguments.json:
        tables = {name: {row: vars(values) for row, values in report.rows.items()} for name, report in reports.items()}
        files.print_json(tables if len(tables) > 1 else next(iter(tables.values())))
    elif not arguments.quiet:
        for name, report in reports.items():
            text = str(report) if arguments.histogram else f"{report.mesh}\n{report.table()}"
            print(f"{name}: {text}" if name else text)


def run_convert(arguments: argparse.Namespace, inputs: Inputs) -> None:
    """One format into another."""
    from .. import io

    files.check_names([arguments.output], [arguments.input])
    mesh = files.read(arguments.input)
    inputs["mesh"] = mesh
    io.write(arguments.output, mesh)
    if arguments.json:
        counts = {"points": mesh.n_points, "cells": mesh.n_cells}
        files.print_json({"input": arguments.input, "output": arguments.output, **counts})
    elif not arguments.quiet:
        print(f"{arguments.output}: {mesh!r}")


def run_warmup(arguments: argparse.Namespace, inputs: Inputs) -> None:
    """Run the gallery's small call of each operation, which compiles what it needs."""
    from .._numba import cache_folder, clean_cache
    from ..gallery import warm_up

    with terminal.progress_bar(arguments.quiet) as bar:
        seconds = warm_up(bar)
    stale = clean_cache()
    if arguments.json:
        files.print_json({"seconds": seconds, "cache": str(cache_folder()), "stale_removed": stale})
    elif not arguments.quiet:
        print(terminal.table([(operations()[name].label, f"{time:.2f} s") for name, time in seconds.items()]))
        print(f"compiled kernels are kept in {cache_folder()}")
        if stale:
            print(f"removed {stale} folder{'s' * (stale > 1)} of older versions")


def run_demo(arguments: argparse.Namespace, inputs: Inputs) -> None:
    """The main job on an airfoil that ships with meshcore."""
    from ..demo import run

    with terminal.progress_bar(arguments.quiet) as bar:
        text = run(arguments.folder, progress=bar)
    if not arguments.quiet and text:
        print(text)
