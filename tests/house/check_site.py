"""check_site.py FOLDER: links of a folder of HTML pages lead somewhere.

Each href and src names a file in the folder or an anchor of a page. Addresses on the web are not fetched.
"""
import html.parser
import pathlib
import re
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    """Links and anchors of one page."""

    def __init__(self, path):
        super().__init__()
        self.links, self.anchors = set(), set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.add(urllib.parse.unquote(value))
            elif name == "id" or (name == "name" and tag == "a"):
                self.anchors.add(value)


def faults_in(folder):
    pages = {path: Page(path) for path in sorted(folder.rglob("*.html"))}
    if not pages:
        sys.exit(f"no HTML pages below {folder}")
    faults, count = [], 0
    for path, page in pages.items():
        for link in sorted(page.links):
            count += 1
            if re.match(r"[a-z]+:", link):
                continue
            name, _, anchor = link.partition("#")
            file = path.parent / name if name else path
            where = f"{path.relative_to(folder)}: {link}"
            if not file.is_file():
                faults.append(f"{where}: no such file")
            elif anchor and file.suffix == ".html" and anchor not in pages[file].anchors:
                faults.append(f"{where}: no such anchor")
    return faults, count, len(pages)


def main(folder):
    faults, links, pages = faults_in(folder)
    if faults:
        sys.exit("\n".join(faults))
    print(f"{links} links in {pages} pages lead somewhere")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]).resolve())
