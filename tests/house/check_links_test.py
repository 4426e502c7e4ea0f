"""check_links.py finds links that lead nowhere."""
import pathlib
import tempfile
import unittest

from check_links import faults_in


class Links(unittest.TestCase):
    def faults(self, text):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "docs").mkdir()
            (root / "docs/other.md").write_text("# Other page\n\n## Two words\n")
            (root / "README.md").write_text(text)
            return faults_in(root)[0]

    def test_files_and_headings_are_found(self):
        self.assertEqual(self.faults("# Top\n[a](docs/other.md) [b](docs/other.md#two-words) [c](#top) ![d](docs/other.md)"), [])
        self.assertEqual(self.faults("[web](https://example.org/nothing)"), [])

    def test_a_missing_file_is_a_fault(self):
        self.assertEqual(self.faults("x\n[a](docs/none.md)"), ["README.md:2: docs/none.md: no such file"])
        self.assertEqual(len(self.faults("![picture](tower.png)")), 1)

    def test_a_missing_heading_is_a_fault(self):
        self.assertEqual(self.faults("[a](docs/other.md#three)"), ["README.md:1: docs/other.md#three: no such heading"])

    def test_a_repeated_heading_has_a_number(self):
        self.assertEqual(self.faults("# A\n# A\n[a](#a) [b](#a-1)"), [])
        self.assertEqual(len(self.faults("# A\n# A\n[c](#a-2)")), 1)

    def test_code_is_not_a_link(self):
        self.assertEqual(self.faults("`[a](none.md)`\n```\n[a](none.md)\n```\n"), [])


if __name__ == "__main__":
    unittest.main()
