"""Usage: make_site.py SAMARA FOLDER

Lays the pages of docs out in FOLDER for Sphinx: with the contents that docs/index.md gives by its headings, a page for
each model that the command SAMARA knows, and without links to what is no page.
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys

DOCS = pathlib.Path(__file__).resolve().parents[1]
LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(([^)\s#]+)(#[^)\s]*)?\)")


def without_links_outside(page, text):
    """Files beside the pages are part of the source, not of the site: they are named only."""

    def kept(match):
        target = match.group(2)
        inside = re.match(r"\w+:", target) or (page.parent / target).resolve().is_relative_to(DOCS)
        return match.group(0) if inside else match.group(1)

    return LINK.sub(kept, text)


def contents(index):
    """The page with a table of contents below each of its headings of the second level."""
    parts = re.split(r"(?m)^(?=## )", index)
    result = parts[0]
    for part in parts[1:]:
        pages = list(dict.fromkeys(t.removesuffix(".md") for _, t, anchor in LINK.findall(part) if t.endswith(".md") and not anchor))
        pages += ["reference/models"] if part.startswith("## Reference") else []
        caption = part.splitlines()[0].removeprefix("## ")
        if part.startswith("## Reference"):
            part += "- <a href=\"api/index.html\">The library</a>: every header.\n"
        result += part.rstrip() + "\n\n```{toctree}\n:hidden:\n:caption: " + caption + "\n\n" + "\n".join(pages) + "\n```\n\n"
    return result


def number(value):
    return f"{value:g}"


def parameter(entry):
    if entry["default"] is not None:
        default = number(entry["default"])
    else:
        default = f"`{entry['derived']}`" if entry["derived"] else "required"
    bounds = [] if entry["lower"] is None else [f"{'at least' if entry['lower_inclusive'] else 'more than'} {number(entry['lower'])}"]
    bounds += [] if entry["upper"] is None else [f"at most {number(entry['upper'])}"]
    unit = "a number" if entry["unit"] == "1" else entry["unit"]
    return f"- **`{entry['name']}`** ({unit}; default: {default}{''.join('; ' + b for b in bounds)}): {entry['description']}"


def model_page(model):
    """Everything that the command says of a model, all of it made from the code."""
    lines = [f"# `{model['name']}`", "", model["title"], "", "```text", *model["equations"].split(",  "), "```", ""]
    for key, word in (("frames", "Frames"), ("source", "Source"), ("validity", "Valid where")):
        if model.get(key):
            lines += [f"**{word}:** {model[key]}", ""]
    if model["parameters"]:
        lines += ["## Parameters", "", *map(parameter, model["parameters"]), ""]
    if model["states"]:
        lines += ["## States", ""]
        for state in model["states"]:
            start = number(state["default_initial"])
            unit = "a number" if state["unit"] == "1" else state["unit"]
            lines += [f"- **`{state['name']}`** ({unit}; at the start {start}): {state['description']}"]
        lines += [""]
    return "\n".join(lines)


def main():
    samara, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(DOCS, folder, ignore=shutil.ignore_patterns("site", "*.py", "__pycache__"))
    shutil.copy(DOCS / "site" / "conf.py", folder)
    (folder / "_static").mkdir()
    for page in DOCS.rglob("*.md"):
        text = without_links_outside(page, page.read_text())
        (folder / page.relative_to(DOCS)).write_text(contents(text) if page == DOCS / "index.md" else text)
    models = json.loads(subprocess.run([samara, "models", "--json"], capture_output=True, text=True, check=True).stdout)["models"]
    place = folder / "reference" / "models"
    place.mkdir()
    for model in models:
        (place / f"{model['name']}.md").write_text(model_page(model))
    rows = [f"- [`{m['name']}`](models/{m['name']}.md): {m['title']}" for m in models]
    tree = ["```{toctree}", ":hidden:", "", *(f"models/{m['name']}" for m in models), "```"]
    head = ["# Models", "", "As the command knows them (`samara models`). Values are in SI units.", ""]
    (folder / "reference" / "models.md").write_text("\n".join([*head, *rows, "", *tree, ""]))


if __name__ == "__main__":
    main()
