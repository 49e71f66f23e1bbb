"""Usage: make_site.py SAMARA FOLDER

Lays the pages of docs out in FOLDER for Sphinx: with the contents that docs/index.md gives by its headings, a page for
each model that the command SAMARA knows, the notebooks of examples/python as they run here, and without links to what is
no page. The package samara is the one that PYTHONPATH leads to.
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
        file = (page.parent / target).resolve()
        inside = re.match(r"\w+:", target) or (file.is_relative_to(DOCS) and not file.is_dir())
        return match.group(0) if inside else match.group(1)

    return LINK.sub(kept, text)


def contents(index):
    """The page with a table of contents below each of its headings of the second level."""
    parts = re.split(r"(?m)^(?=## )", index)
    result = parts[0]
    for part in parts[1:]:
        pages = list(dict.fromkeys(t.removesuffix(".md") for _, t, anchor in LINK.findall(part) if t.endswith(".md") and not anchor))
        pages += ["reference/models", "reference/options"] if part.startswith("## Reference") else []
        pages += ["tutorials/notebooks"] if part.startswith("## Tutorials") else []
        caption = part.splitlines()[0].removeprefix("## ")
        if part.startswith("## Tutorials"):
            part = part.rstrip() + "\n- [Notebooks](tutorials/notebooks.md): the same jobs from Python, with their pictures.\n"
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


def option(entry):
    notes = [entry["value"]] if entry["value"] and entry["value"] != entry["names"][0] else []
    notes += ["one or more" if entry["several"] else ""] + [f"one of {', '.join(entry['choices'])}" if entry["choices"] else ""]
    notes += ["required" if entry["required"] else ""] + [f"default: {entry['default']}" if entry["default"] else ""]
    told = "; ".join(note for note in notes if note)
    return f"- **`{', '.join(entry['names'])}`**{f' ({told})' if told else ''}: {entry['text']}"


def command_page(command):
    """Everything that the command says of one of its subcommands."""
    lines = [f"# `samara {command['name']}`", "", command["summary"], ""]
    for key, word in (("inputs", "Inputs"), ("options", "Options")):
        if command[key]:
            lines += [f"## {word}", "", *map(option, command[key]), ""]
    if command["examples"]:
        lines += ["## Examples", "", "```text", *command["examples"], "```", ""]
    return "\n".join(lines)


def add_pages(place, title, words, entries):
    """A folder of pages, and one that lists them. @param entries (name, what it is, text of its page)"""
    place.mkdir(exist_ok=True)
    for name, _, text in entries:
        (place / f"{name}.md").write_text(text)
    rows = [f"- [`{name}`]({place.name}/{name}.md): {what}" for name, what, _ in entries]
    tree = ["```{toctree}", ":hidden:", "", *(f"{place.name}/{name}" for name, *_ in entries), "```"]
    place.with_suffix(".md").write_text("\n".join([f"# {title}", "", words, "", *rows, "", *tree, ""]))


def notebook_pages(place):
    """(name, title, text) of each notebook, run from the first cell to the last; its pictures go beside the pages."""
    place.mkdir()
    for path in sorted((DOCS.parent / "examples" / "python").glob("*.ipynb")):
        subprocess.run([sys.executable, "-m", "nbconvert", "--log-level=ERROR", "--to", "markdown", "--execute", "--output-dir",
                        place, path], check=True)
        text = without_links_outside(path, (place / f"{path.stem}.md").read_text())
        yield path.stem, re.search(r"(?m)^# (.*)", text)[1], text


def told(samara, *arguments):
    return json.loads(subprocess.run([samara, *arguments, "--json"], capture_output=True, text=True, check=True).stdout)


def main():
    samara, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(DOCS, folder, ignore=shutil.ignore_patterns("site", "*.py", "__pycache__"))
    shutil.copy(DOCS / "site" / "conf.py", folder)
    (folder / "_static").mkdir()
    for page in DOCS.rglob("*.md"):
        text = without_links_outside(page, page.read_text())
        (folder / page.relative_to(DOCS)).write_text(contents(text) if page == DOCS / "index.md" else text)
    reference = folder / "reference"
    add_pages(reference / "models", "Models", "As the command knows them (`samara models`). Values are in SI units.",
              [(m["name"], m["title"], model_page(m)) for m in told(samara, "models")["models"]])
    add_pages(reference / "options", "Options of every command", "As the command tells of itself (`samara help`).",
              [(c["name"], c["summary"], command_page(c)) for c in told(samara, "help")["commands"]])
    place = folder / "tutorials" / "notebooks"
    add_pages(place, "Notebooks", "Run when this site was made; their files are in `examples/python`.", list(notebook_pages(place)))


if __name__ == "__main__":
    main()
