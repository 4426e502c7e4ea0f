"""check_links.py ROOT: links of the documents lead somewhere.

Each [text](target) of *.md, docs/*.md and docs/**/*.md names a file of the repository, and its #anchor a heading of
that file (GitHub's rules). Pictures count as links. Addresses on the web are not fetched.
"""
import pathlib
import re
import sys

LINK = re.compile(r"!?\[(?:[^\]\[]|\[[^\]]*\])*\]\(([^)\s]+)(?:\s+\"[^\"]*\")?\)")
CODE = re.compile(r"`[^`]*`")


def lines_without_code(path):
    """(line number, line) outside fenced blocks, without code spans."""
    fenced = False
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            yield number, CODE.sub("", line)


def headings(path):
    """(line number, anchor) of the headings of a document, by GitHub's rules: a repeated one gets a number."""
    used, fenced = {}, False
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        heading = None if fenced else re.match(r"#+\s+(.*?)\s*#*$", line)
        if heading:
            text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.group(1)).lower()
            anchor = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
            before = used.get(anchor, 0)
            used[anchor] = before + 1
            yield number, f"{anchor}-{before}" if before else anchor


def anchors(path):
    """Anchors of the headings of a document."""
    return {anchor for _, anchor in headings(path)}


def faults_in(root):
    documents = sorted(root.glob("*.md")) + sorted((root / "docs").rglob("*.md"))
    if not documents:
        sys.exit(f"no documents below {root}: is ROOT right?")
    faults, links = [], 0
    for document in documents:
        for number, line in lines_without_code(document):
            for target in LINK.findall(line):
                links += 1
                if re.match(r"[a-z]+:", target):
                    continue
                name, _, anchor = target.partition("#")
                file = document.parent / name if name else document
                where = f"{document.relative_to(root)}:{number}: {target}"
                if not file.exists():
                    faults.append(f"{where}: no such file")
                elif anchor and (file.suffix != ".md" or anchor not in anchors(file)):
                    faults.append(f"{where}: no such heading")
    return faults, links, len(documents)


def main(root):
    faults, links, documents = faults_in(root)
    if faults:
        sys.exit("\n".join(faults))
    print(f"{links} links in {documents} documents lead somewhere")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]).resolve())
