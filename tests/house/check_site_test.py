"""check_site.py finds dead links of a site, and doxygen_markdown.py writes links that Doxygen can follow."""
import pathlib
import tempfile
import unittest

from check_site import faults_in
from doxygen_markdown import for_doxygen


class Site(unittest.TestCase):
    def faults(self, text):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "other.html").write_text('<h2 id="part">Part</h2><a name="old"></a>')
            (root / "index.html").write_text(text)
            return faults_in(root)[0]

    def test_files_and_anchors_are_found(self):
        self.assertEqual(self.faults('<p id="here"><a href="other.html#part">a</a><a href="#here">b</a><a href="other.html#old">c</a>'), [])
        self.assertEqual(self.faults('<a href="https://example.org/nothing">web</a>'), [])

    def test_a_missing_file_is_a_fault(self):
        self.assertEqual(self.faults('<a href="formats.md">a</a>'), ["index.html: formats.md: no such file"])
        self.assertEqual(len(self.faults('<img src="tower.png">')), 1)

    def test_a_missing_anchor_is_a_fault(self):
        self.assertEqual(self.faults('<a href="other.html#none">a</a>'), ["index.html: other.html#none: no such anchor"])


class Markdown(unittest.TestCase):
    def filtered(self, text):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "examples").mkdir()
            (root / "page.md").write_text(text)
            return for_doxygen(root / "page.md")

    def test_headings_have_labels_and_links_lead_to_them(self):
        self.assertEqual(self.filtered("# Top\n## Two `words`\n[a](other.md#two-words) [b](#two-words)\n"),
                         "# Top\n## Two `words` {#page-two-words}\n[a](@ref other-two-words) [b](@ref page-two-words)\n")

    def test_programs_are_copied_and_folders_are_text(self):
        self.assertEqual(self.filtered("[a](examples/a.py), [examples/](examples) [c](other.md)\n"),
                         "[a](a.py), examples/ [c](other.md)\n")

    def test_code_stays(self):
        text = "```\n## no heading\n[a](x.py)\n```\n"
        self.assertEqual(self.filtered(text), text)


if __name__ == "__main__":
    unittest.main()
