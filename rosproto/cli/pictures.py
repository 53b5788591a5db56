"""Drawings of graphs as files: DOT and SVG directly, PNG and PDF by Graphviz."""

from __future__ import annotations

import argparse
import shutil
import subprocess
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from rosproto.cli.exit_codes import CommandError
from rosproto.cli.options import folder_exists
from rosproto.files import write_file

FORMS = {".dot": "dot", ".gv": "dot", ".svg": "svg", ".txt": "text", ".png": "png", ".pdf": "pdf"}
"""What is written, by the ending of the file."""
_BY_GRAPHVIZ = ("png", "pdf")
_PATIENCE = 60.0


def add_picture_options(parser: argparse.ArgumentParser, default: str, file: str) -> None:
    """Add --format and --output, with what their helps say of the default and of the file."""
    parser.add_argument("--format", choices=("text", "dot", "svg", "png", "pdf"), help=f"default: {default}")
    parser.add_argument("-o", "--output", type=folder_exists, metavar="FILE", help=file)


def form_of(file: Path | None, asked: str | None) -> str:
    """Return the format: as given, else by the file's ending; text without a file.

    Raises:
        CommandError: The ending is unknown or contradicts the given format.
    """
    ending = FORMS.get(file.suffix.lower()) if file else None
    if asked and ending in (None, asked):
        return asked
    if file is None:
        return "text"
    if asked:
        raise CommandError(f"{file}: the name means {ending}, but --format is {asked}; omit one of them")
    if ending is None:
        raise CommandError(
            f"{file}: this is not the ending of a picture; use one of {', '.join(FORMS)}, or give --format"
        )
    return ending


def write_picture(file: Path | None, form: str, writers: Mapping[str, Callable[[], str]]) -> str:
    """Write the picture to the file, or return it for standard output.

    Args:
        file: Output; None for standard output.
        form: One of the values of `FORMS`.
        writers: Functions that return text, dot and svg.

    Raises:
        CommandError: Graphviz is needed, and is missing or failed.
    """
    if form in _BY_GRAPHVIZ:
        if file is None:
            raise CommandError(f"{form} is not text for a terminal; give -o FILE.{form}")
        write_file(file, _by_graphviz(writers["dot"](), form))
        return ""
    text = writers[form]()
    if file is None:
        return text
    write_file(file, text.encode())
    return ""


def _by_graphviz(dot: str, form: str) -> bytes:
    program = shutil.which("dot")
    if program is None:
        raise CommandError(
            f"{form} is drawn by Graphviz, and its program `dot` is not installed; .svg (for any browser) "
            "and .dot are written without it"
        )
    try:
        done = subprocess.run(
            [program, f"-T{form}"], input=dot.encode(), capture_output=True, timeout=_PATIENCE, check=False
        )
    except subprocess.TimeoutExpired:
        raise CommandError(f"Graphviz has not drawn it within {_PATIENCE:g} s; write .svg instead") from None
    if done.returncode:
        said = " ".join(done.stderr.decode("utf-8", "replace").split())[:300]
        raise CommandError(f"Graphviz failed with code {done.returncode}: {said}; write .svg instead")
    return done.stdout


def svg_page(width: int, height: float, style: str, parts: Iterable[str]) -> str:
    """Return an SVG document of this size on white."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}">\n<style>{style}.page{{fill:#fff;stroke:none}}</style>\n'
        f'<rect class="page" width="{width}" height="{height}"/>\n' + "\n".join(parts) + "\n</svg>\n"
    )


def quoted(text: str) -> str:
    """Quote a name for DOT."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
