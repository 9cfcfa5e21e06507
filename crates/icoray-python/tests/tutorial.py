"""The notebook of the book's tutorial, as its page says it.

Blocks of ```python are cells of code, the text between them cells of Markdown. Lines with a picture are left out, as
the notebook draws it.
"""

from __future__ import annotations

import json
import pathlib
from typing import Any

ROOT = pathlib.Path(__file__).parents[3]
PAGE = ROOT / "docs/src/tutorial.md"
NOTEBOOK = ROOT / "docs/src/tutorial.ipynb"


def cells(page: str) -> list[tuple[str, str]]:
    """Kind ("code" or "markdown") and text of each cell."""
    found: list[tuple[str, list[str]]] = [("markdown", [])]
    for line in page.splitlines():
        if line == "```python":
            found.append(("code", []))
        elif line == "```" and found[-1][0] == "code":
            found.append(("markdown", []))
        elif found[-1][0] == "code" or not line.startswith("!["):
            found[-1][1].append(line)
    texts = [(kind, "\n".join(lines).strip()) for kind, lines in found]
    return [(kind, text) for kind, text in texts if text]


def notebook(page: str) -> str:
    """The notebook, without outputs, as text."""
    made = []
    for number, (kind, text) in enumerate(cells(page)):
        cell: dict[str, Any] = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}}
        if kind == "code":
            cell |= {"execution_count": None, "outputs": []}
        made.append(cell | {"source": text.splitlines(keepends=True)})
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    whole = {"cells": made, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"
