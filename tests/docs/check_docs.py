#!/usr/bin/env python3
"""Checks the pages of the project: README.md, CHANGELOG.md, CONTRIBUTING.md and all of docs/.

    check_docs.py [--root FOLDER]      exit status 1 and one line a fault, each as FILE:LINE: TEXT

Faults are: a link to a file or a heading that is not there, a line of prose of more than 240 columns, and a page of
docs/ that docs/README.md does not list.
"""
import argparse
import os
import re
import sys

MOST_COLUMNS = 240
INDEX = "docs/README.md"
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")


def pages(root):
    """Paths of all pages, relative to `root`."""
    found = [name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md") if os.path.exists(f"{root}/{name}")]
    for folder, folders, names in os.walk(os.path.join(root, "docs")):
        folders.sort()
        found += [os.path.relpath(os.path.join(folder, name), root) for name in sorted(names) if name.endswith(".md")]
    return found


def prose_lines(root, page):
    """Number and text of all lines outside of code."""
    fenced = False
    with open(os.path.join(root, page), encoding="utf-8") as lines:
        for number, line in enumerate(lines, 1):
            line = line.rstrip("\n")
            if line.lstrip().startswith("```"):
                fenced = not fenced
            elif not fenced and not line.startswith("    "):
                yield number, line


def anchors(root, page):
    """What links to headings of the page may name, as the usual renderers make it from their words."""
    headings = [line.lstrip("#").strip().lower() for _, line in prose_lines(root, page) if line.startswith("#")]
    return {re.sub(r"[^\w\- ]", "", heading).replace(" ", "-") for heading in headings}


def check_link(root, page, target):
    """What is wrong with a link of the page, or None."""
    if re.match(r"[a-z]+:", target):
        return None
    path, _, anchor = target.partition("#")
    path = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
    if not os.path.exists(os.path.join(root, path)):
        return f"links to {path}, which is not there"
    if anchor and path.endswith(".md") and anchor not in anchors(root, path):
        return f"links to #{anchor} of {path}, which has no such heading"
    return None


def check(root):
    faults, listed = [], set()
    for page in pages(root):
        for number, line in prose_lines(root, page):
            if len(line) > MOST_COLUMNS and not line.startswith("|"):
                faults.append(f"{page}:{number}: {len(line)} columns; break the line behind a sentence or a clause")
            for target in LINK.findall(re.sub(r"`[^`]*`", "", line)):
                fault = check_link(root, page, target)
                if fault:
                    faults.append(f"{page}:{number}: {fault}")
                if page == INDEX:
                    listed.add(os.path.normpath(os.path.join("docs", target.partition("#")[0])))
    if os.path.exists(os.path.join(root, INDEX)):
        faults += [f"{INDEX}:1: does not list {page}"
                   for page in pages(root) if page.startswith("docs") and page != INDEX and page not in listed]
    return faults


def main(words=None):
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", default=os.path.dirname(os.path.dirname(here)), help="the checkout")
    faults = check(parser.parse_args(words).root)
    print("\n".join(faults) or "every link leads somewhere, and every line of prose is short enough")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
