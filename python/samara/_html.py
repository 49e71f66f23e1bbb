"""How things look in a notebook, and pages for the browser."""

from __future__ import annotations

import html
import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from . import _core
from ._errors import ArgumentError, writing

if TYPE_CHECKING:
    from ._building import Path
    from ._codebook import Codebook
    from ._fitting import Coefficient, FitResult


def unit(text: str) -> str:
    """" m/s", or nothing for a number without unit."""
    return "" if text == "1" else f" {text}"


def write_page(path: "Path", page: str) -> None:
    """Writes a page for the browser: who reads it meanwhile sees the old one or the new, and never a part.

    :raises ArgumentError: unless the name ends in .html: a name given by mistake would cost the file that has it
    :raises InputError: (an ``OSError``) where it cannot be written
    """
    name = os.fspath(path)
    if not name.lower().endswith(".html"):
        raise ArgumentError(f'path is "{name}", expected a name that ends in .html')
    with writing():
        _core.write_text(path, page)


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    cells = "".join(f"<th>{html.escape(h)}</th>" for h in head)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(str(c))}</td>" for c in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table>"


def flag(good: bool, text: str) -> str:
    return f'<b style="color:{"#1a7f37" if good else "#cf222e"}">{html.escape(text)}</b>'


def _span(sizes: Iterable[int]) -> str:
    least, most = min(all_sizes := list(sizes)), max(all_sizes)
    return str(least) if least == most else f"{least}..{most}"


def codebook(book: "Codebook", outlines: list[dict[str, Any]]) -> str:
    rows = []
    for k, c in enumerate(book.coordinates):
        nodes = _span(p["axes"][k]["nodes"] for p in outlines)
        rows.append((c.name, c.unit, f"{c.lower:g} to {c.upper:g}", outlines[0]["axes"][k]["basis"], nodes))
    groups = []
    for k, g in enumerate(outlines[0]["groups"]):
        ranks = _span(max(p["groups"][k]["ranks"]) for p in outlines if k < len(p["groups"]))
        form = "tensor train, ranks up to" if g["kind"] == "train" else "sum of products, terms"
        groups.append((", ".join(g["outputs"]), f"{form} {ranks}"))
    certificate = book.certificate
    if certificate is None:
        verdict = flag(False, "no certificate")
    else:
        errors = table(
            ("output", "unit", "largest error", "95 %", "largest, SI"),
            ((o.name, o.unit, f"{o.max:.2e}", f"{o.p95:.2e}", f"{o.max_si:.2e}") for o in certificate.outputs.values()),
        )
        said = certificate.verdict if certificate.met else certificate.verdict.upper()
        verdict = flag(certificate.met, f"certificate {said}") + html.escape(
            f": largest error {certificate.max_error:.3g}, asked for {certificate.tolerance:.3g}, "
            f"at {certificate.points} points"
            + (f", of which {certificate.failed_points} failed," if certificate.failed_points else "")
            + f" against {certificate.integrator}"
        )
        verdict += errors
    title = html.escape(book.title or f"Codebook of {book.model['name']}")
    return (
        f"<div><b>{title}</b>, {len(outlines)} piece{'s' if len(outlines) > 1 else ''}<br>{verdict}"
        + table(("axis", "unit", "box", "basis", "nodes"), rows)
        + table(("outputs", "form"), groups)
        + "</div>"
    )


def fit(result: "FitResult", coefficients: Iterable["Coefficient"]) -> str:
    rows = (
        (c.name, c.unit, f"{c.value:.6g}", "" if c.standard_error is None else f"{c.standard_error:.2g}", c.verdict)
        for c in coefficients
    )
    warnings = "".join(f"<li>{html.escape(w)}</li>" for w in result.warnings)
    return (
        f"<div>{flag(result.is_usable, result.message)}"
        + table(("coefficient", "unit", "value", "standard error", "verdict"), rows)
        + (f"<ul>{warnings}</ul>" if warnings else "")
        + "</div>"
    )
