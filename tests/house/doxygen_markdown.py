"""doxygen_markdown.py FILE: a document as Doxygen 1.9 needs it, on the standard output (FILTER_PATTERNS in Doxyfile).

GitHub's form of links is kept in the documents. Doxygen resolves `page.md` alone: here headings get labels, links to
headings become references to these, links to programs lead to the copies in the site (HTML_EXTRA_FILES), and a link to a
folder becomes its text. Lines keep their numbers.
"""
import pathlib
import re
import sys

from check_links import LINK, headings


def label(document, anchor):
    return f"{document.stem}-{anchor}"


def link(document, match):
    target = match.group(1)
    name, _, anchor = target.partition("#")
    if re.match(r"[a-z]+:", target):
        return match.group(0)
    start, end = match.start(1) - match.start(0), match.end(1) - match.start(0)
    file = document.parent / name if name else document
    if anchor:
        return match.group(0)[:start] + "@ref " + label(file, anchor) + match.group(0)[end:]
    if file.is_dir():
        return match.group(0)[1 : start - 2]  # without "[" and "]("
    if file.suffix == ".py":
        return match.group(0)[:start] + file.name + match.group(0)[end:]
    return match.group(0)


def for_doxygen(document):
    labels = dict(headings(document))
    lines, fenced = [], False
    for number, line in enumerate(document.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            line = LINK.sub(lambda match: link(document, match), line)
            if line.startswith("##"):  # a label would rename the page that the first heading stands for
                line += f" {{#{label(document, labels[number])}}}"
        lines.append(line)
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8")
    sys.stdout.write(for_doxygen(pathlib.Path(sys.argv[1])))
