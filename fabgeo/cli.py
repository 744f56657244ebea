"""The `fabgeo` command: arguments in, exit codes out; the work is done in `fabgeo.build`.

Exit codes: 0 all within limits, 1 built but some verdict fails, 2 bad input or a full disk,
3 internal failure, 130 interrupted.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from fabgeo.errors import FabgeoError

if TYPE_CHECKING:
    from fabgeo.build.progress import Listener, Progress

# The systems solved here have small blocks: threads of the linear algebra only stand in each
# other's way, and in that of the processes that work on parts.
for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")

# A part that kills its process is told by its mark, without the stack of the dead.
if not os.environ.get("FABGEO_DEBUG"):
    os.environ.setdefault("PYTHONFAULTHANDLER", "")

PROCESSES = os.cpu_count() or 1
OK, FAILED, BAD_INPUT, INTERNAL, INTERRUPTED = 0, 1, 2, 3, 130

TRADEOFF = {
    "deviation_mm": ("mm", "{:g}"),
    "kink_deg": ("deg", "{:g}"),
    "flat": ("flat", "{:.0%}"),
    "cylinder": ("cyl.", "{:.0%}"),
    "cone": ("cone", "{:.0%}"),
    "developable": ("dev.", "{:.0%}"),
    "cost": ("cost", "{:g}"),
    "bound": ("least", "{:.0f}"),
    "one_by_one": ("alone", "{:g}"),
    "radii": ("radii", "{}"),
    "gap_max_mm": ("gap", "{:.2f}"),
    "kink_max_deg": ("kink", "{:.2f}"),
}

app = typer.Typer(
    name="fabgeo",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

ProjectFile = Annotated[Path, typer.Argument(metavar="PROJECT.toml", help="The project file.")]
Jobs = Annotated[
    int, typer.Option("--jobs", min=1, help="Processes for work that is independent per part.")
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON for scripts, no progress bars.")]


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"fabgeo {version('fabgeo')}")
        raise typer.Exit(OK)


@app.callback()
def fabgeo(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_version, is_eager=True, help="Say which version this is."
        ),
    ] = False,
) -> None:
    """From a freeform architectural surface to the files a workshop cuts from."""


@app.command()
def build(
    project: ProjectFile,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The output folder.")],
    jobs: Jobs = PROCESSES,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Ignore what an earlier build left to use again.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Build the hand-over package of a project."""
    from fabgeo.build import build_package

    with _progress(quiet=as_json) as listener:
        package = build_package(project, out, jobs=jobs, fresh=fresh, listener=listener)
    if as_json:
        _print_json(package.as_dict())
    else:
        _print_package(package)
    raise typer.Exit(OK if package.passed else FAILED)


@app.command()
def check(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A written package.")],
    jobs: Jobs = PROCESSES,
    as_json: Json = False,
) -> None:
    """Measure a written package from its files alone."""
    from fabgeo.review.check import check_package

    report = check_package(folder, jobs=jobs)
    if as_json:
        _print_json(report.as_dict())
    else:
        for line in report.lines():
            typer.echo(line)
    raise typer.Exit(OK if report.ok else FAILED)


@app.command()
def inspect(
    surface: Annotated[
        Path, typer.Argument(metavar="SURFACE", help="A surface file, or a project file.")
    ],
    unit: Annotated[
        str | None, typer.Option("--unit", help="Length unit of the file: mm, cm, m, in or ft.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Say what a surface file holds: faces, size, unit, curvature, boundary, strip directions."""
    from fabgeo.build.surface import inspect_file

    found = inspect_file(surface, unit)
    if as_json:
        _print_json(found.as_dict())
    else:
        for line in found.lines():
            typer.echo(line)


@app.command()
def init(
    path: Annotated[
        Path, typer.Argument(metavar="PROJECT.toml", help="The project file to write.")
    ] = Path("project.toml"),
) -> None:
    """Write a commented project file that builds as it is."""
    from fabgeo.build.template import write_template

    write_template(path)
    typer.echo(f"{path} written. Build it with: fabgeo build {path} --out outputs/first")


@app.command()
def tradeoff(
    project: ProjectFile,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Folder for the table and plot.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Table and plot of what panels can be made as, over tolerances and angles."""
    from fabgeo.build.tradeoff import tradeoff_of

    with _progress(quiet=as_json) as listener:
        table = tradeoff_of(project, out, listener=listener)
    if as_json:
        _print_json(table)
    else:
        _print_rows(f"What {table['panels']} panels could be made as", table["rows"], TRADEOFF)
        for line in table["notes"]:
            typer.echo(line)


def main() -> NoReturn:
    """Run the command; errors of fabgeo become one line and an exit code."""
    stopped = _stoppable()
    _keep_output()
    try:
        app(standalone_mode=True)
    except FabgeoError as error:
        code = INTERNAL if isinstance(error, RuntimeError) else BAD_INPUT
        typer.secho(f"fabgeo: {error}", err=True, fg=typer.colors.RED)
        sys.exit(code)
    except SystemExit as end:
        if end.code == INTERRUPTED:  # typer turns the interrupt into this
            typer.echo("fabgeo: interrupted; what was finished is kept", err=True)
        raise
    except Exception as error:
        if stopped:  # what was interrupted, a library while it loads, made of it
            typer.echo("fabgeo: interrupted; what was finished is kept", err=True)
            sys.exit(INTERRUPTED)
        if os.environ.get("FABGEO_DEBUG"):
            raise
        typer.secho(
            f"fabgeo: internal failure: {type(error).__name__}: {error} "
            "(set FABGEO_DEBUG=1 for the traceback, and please report it)",
            err=True,
            fg=typer.colors.RED,
        )
        sys.exit(INTERNAL)
    sys.exit(OK)


def _stoppable() -> list[int]:
    """Let SIGTERM end the command as Ctrl-C does; the signals that came."""
    came: list[int] = []

    def interrupt(number: int, _: object) -> NoReturn:
        came.append(number)
        raise KeyboardInterrupt

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, interrupt)
    return came


def _keep_output() -> None:
    """Keep standard output for the command's own words: scripts expect JSON alone there.

    Libraries print from C (HiGHS tells its version), also in other processes: that goes nowhere.
    """
    own = sys.stdout
    if own is None or own.fileno() != 1:
        return
    own.flush()
    kept = open(os.dup(1), "w", buffering=1, encoding=own.encoding, errors=own.errors)  # noqa: SIM115
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    sys.stdout = kept


@contextmanager
def _progress(quiet: bool) -> Iterator[Listener | None]:
    """One bar a stage on the terminal, or nothing."""
    if quiet:
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars

    bars = Bars(
        TextColumn("{task.description:<12}"),
        BarColumn(bar_width=30),
        TimeElapsedColumn(),
        TextColumn("{task.fields[note]}"),
        console=Console(stderr=True),
    )
    tasks: dict[str, Any] = {}

    def listen(news: Progress) -> None:
        if news.stage not in tasks:
            tasks[news.stage] = bars.add_task(news.stage, total=None, note="")
        total = news.total or (1 if news.finished else None)
        done = total if news.finished and total else news.done
        fields: dict[str, Any] = {"note": news.note} if news.note else {}
        bars.update(tasks[news.stage], total=total, completed=done, **fields)
        if news.finished:
            bars.stop_task(tasks[news.stage])

    with bars:
        yield listen


def _print_json(data: Any) -> None:
    typer.echo(json.dumps(data, indent=1))


def _print_package(package: Any) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"{package.name}: figures against their limits")
    for column in ("figure", "measured", "limit", "verdict"):
        table.add_column(column, justify="left" if column in ("figure", "verdict") else "right")
    colour = {"good": "green", "warn": "yellow", "fail": "red"}
    for figure, measured, limit, verdict in package.figures():
        style = colour.get(verdict, "")
        table.add_row(figure, measured, limit, f"[{style}]{verdict}[/]" if style else verdict)
    console = Console()
    console.print(table)
    seconds = ", ".join(f"{name} {value:.1f}" for name, value in package.seconds.items())
    console.print(f"seconds by stage: {seconds}", highlight=False)
    for line in package.record.remarks:
        console.print(f"note: {line}", highlight=False, markup=False)
    for line in package.failures:
        console.print(f"fails: {line}", style="red", highlight=False, markup=False)
    console.print(f"package: {package.path}", highlight=False, markup=False)


def _print_rows(
    title: str, rows: list[dict[str, Any]], columns: dict[str, tuple[str, str]]
) -> None:
    """A table within 80 columns: key of a row to its heading and format."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading, _ in columns.values():
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        table.add_row(*(form.format(row[key]) for key, (_, form) in columns.items()))
    Console().print(table)


if __name__ == "__main__":
    main()
