#!/usr/bin/env python3
"""Tests of check_docs.py: small folders of pages, each with one fault planted in it."""
import contextlib
import io
import os
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True  # the sources need not be where one may write

import check_docs  # noqa: E402

PAGES = {
    "README.md": "# Top\n\n[map](docs/map.md#two-words-deep), [web](https://example.org/x), [up](#top)\n",
    "docs/README.md": "# Pages\n\n- [map](map.md)\n",
    "docs/map.md": "# Map\n\n## Two words: `deep`\n\n[back](../README.md)\n",
}
GOOD = "every link leads somewhere, and every line of prose is short enough\n"


def run(pages):
    """Exit status and output of the script over `pages`, a dictionary of texts by path."""
    with tempfile.TemporaryDirectory() as root:
        for path, text in pages.items():
            os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(text)
        with contextlib.redirect_stdout(io.StringIO()) as output:
            status = check_docs.main(["--root", root])
        return status, output.getvalue()


class CheckDocs(unittest.TestCase):
    def expect_fault(self, line, pages):
        """The script must find exactly one fault, whose text is `line`."""
        self.assertEqual(run({**PAGES, **pages}), (1, line + "\n"))

    def test_sound_pages_pass(self):
        self.assertEqual(run(PAGES), (0, GOOD))

    def test_missing_file_is_found(self):
        self.expect_fault("docs/map.md:3: links to docs/gone.md, which is not there",
                          {"docs/map.md": "## Two words deep\n\n[gone](gone.md)\n"})

    def test_missing_heading_is_found(self):
        self.expect_fault("README.md:1: links to #three of docs/map.md, which has no such heading",
                          {"README.md": "[map](docs/map.md#three)\n"})

    def test_long_line_is_found_outside_of_tables_and_code(self):
        long_line = "word " * 50
        self.assertEqual(run({**PAGES, "README.md": f"| {long_line}|\n\n    {long_line}\n\n```\n{long_line}\n```\n"}),
                         (0, GOOD))
        self.expect_fault("README.md:1: 250 columns; break the line behind a sentence or a clause",
                          {"README.md": long_line + "\n"})

    def test_page_that_is_not_listed_is_found(self):
        self.expect_fault("docs/README.md:1: does not list docs/new.md", {"docs/new.md": "# New\n"})


if __name__ == "__main__":
    unittest.main()
