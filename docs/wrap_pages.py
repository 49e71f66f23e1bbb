"""Usage: wrap_pages.py [--check] PAGE ..

Wraps the prose of Markdown pages at 100 characters. Code, tables and headings stay as they are. ./dev format calls it;
with --check it names the pages that it would change, and ends with 1 if there are any.
"""

import pathlib
import re
import sys

WIDTH = 100
ITEM = re.compile(r"(\s*)([-*+]|\d+\.)\s+")
# Read as one word: code, the target of a link, a picture.
WORD = re.compile(r"(?:`+[^`]+`+|!\[[^\]]*\]\([^)]*\)|\]\([^)]*\)|\S)+")
MARKER = re.compile(r"[-+*#>|]+$|\d+[.)]$")  # would begin something else at the start of a line


def wrapped(text, first, rest):
    """Lines of at most WIDTH, where words allow it."""
    lines, line = [], first
    for word in WORD.findall(text):
        if line in (first, rest):
            line += word
        elif len(line) + 1 + len(word) <= WIDTH:
            line += f" {word}"
        else:
            taken = ""
            if MARKER.match(word) and " " in line.strip():
                line, taken = line.rsplit(" ", 1)
            lines.append(line)
            line = f"{rest}{taken} {word}" if taken else rest + word
    return lines + [line]


def pages_lines(lines):
    """The lines of a page, wrapped."""
    result, paragraph, first, rest = [], [], "", ""

    def end():
        if paragraph:
            result.extend(wrapped(" ".join(paragraph), first, rest))
            paragraph.clear()

    fence, in_list = None, False
    for line in lines:
        stripped = line.strip()
        if fence:
            result.append(line)
            if stripped == fence:
                fence = None
            continue
        opening = re.match(r"(`{3,}|~{3,})", stripped)
        verbatim = (stripped.startswith(("|", "#", "<", ":::", "![")) or re.match(r"\([\w-]+\)=$", stripped)
                    or (line.startswith("    ") and not paragraph and not in_list))
        item = ITEM.match(line)
        if opening or not stripped or verbatim:
            end()
            result.append(line)
            fence = opening.group(1) if opening else None
            in_list = in_list and (not stripped or line.startswith(" "))
        elif item and (not paragraph or in_list or item.group(2) != "1." or line[0] != " "):
            end()
            first, rest, in_list = item.group(0), " " * len(item.group(0)), True
            paragraph.append(line[item.end():].strip())
        else:
            if not paragraph:
                first = rest = line[:len(line) - len(line.lstrip())] if in_list else ""
                in_list = in_list and line.startswith(" ")
            paragraph.append(stripped)
    end()
    return result


def main(arguments):
    check = "--check" in arguments
    changed = []
    for page in (pathlib.Path(a) for a in arguments if a != "--check"):
        text = page.read_text()
        new = "\n".join(pages_lines(text.splitlines())) + "\n"
        if new != text:
            changed.append(page)
            if not check:
                page.write_text(new)
    if check and changed:
        print(*(f"{page}: not wrapped at {WIDTH} characters; run ./dev format" for page in changed), sep="\n")
    return 1 if check and changed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
