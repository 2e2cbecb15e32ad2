#!/usr/bin/env python3
"""Tests of include_matrix.py: small trees of files, each with one fault planted in it."""
import contextlib
import io
import os
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True  # the sources need not be where one may write

import include_matrix  # noqa: E402

FILES = {
    "include/clbvh/core/node.hpp": "#pragma once\n#include <vector>\n",
    "include/clbvh/trace/tracer.hpp": '#pragma once\n#include "clbvh/core/node.hpp"\n',
    "src/core/node.cpp": '#include "clbvh/core/node.hpp"\n#include "core/scratch.hpp"\n',
    "src/core/scratch.hpp": "#pragma once\n",
    "src/trace/tracer.cpp": '#include "clbvh/trace/tracer.hpp"\n#  include <CL/cl.h>\n',
    "tools/cli/main.cpp": "#include <clbvh/trace/tracer.hpp>\n",
}
TABLE = """
room core  include/clbvh/core src/core
room trace include/clbvh/trace src/trace
room tools tools
edge trace core only include/clbvh/core/node.hpp
edge tools public   # a comment
outside CL/ trace
"""


def run(files, table=TABLE, *options):
    """Exit status and output of the script over `files`, a dictionary of texts by path."""
    with tempfile.TemporaryDirectory() as root:
        for path, text in files.items():
            os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(text)
        with open(os.path.join(root, "table.txt"), "w", encoding="utf-8") as file:
            file.write(table)
        with contextlib.redirect_stdout(io.StringIO()) as output:
            status = include_matrix.main(["--root", root, "--table", os.path.join(root, "table.txt"), *options])
        return status, output.getvalue()


class IncludeMatrix(unittest.TestCase):
    def expect_fault(self, line, files=None, table=TABLE):
        """The script must find exactly one fault, whose text is `line`."""
        status, output = run({**FILES, **(files or {})}, table)
        self.assertEqual((status, output), (1, line + "\n"))

    def test_allowed_includes_pass(self):
        self.assertEqual(run(FILES), (0, "7 includes of 6 files: every one is allowed\n"))

    def test_undeclared_edge_is_found_where_it_stands(self):
        self.expect_fault("src/core/bad.cpp:3: core must not include include/clbvh/trace/tracer.hpp of trace",
                          {"src/core/bad.cpp": '\n\n #include "clbvh/trace/tracer.hpp"\n'})

    def test_only_holds_for_the_files_it_names(self):
        self.expect_fault("src/trace/bad.cpp:1: trace must not include src/core/scratch.hpp of core",
                          {"src/trace/bad.cpp": '#include "core/scratch.hpp"\n'})

    def test_public_is_not_private(self):
        self.expect_fault("tools/cli/bad.cpp:1: tools must not include src/core/scratch.hpp of core",
                          {"tools/cli/bad.cpp": '#include "core/scratch.hpp"\n'})

    def test_header_beside_the_file_is_found(self):
        self.expect_fault("src/trace/bad.cpp:1: trace must not include src/core/scratch.hpp of core",
                          {"src/trace/bad.cpp": '#include "../core/scratch.hpp"\n'})

    def test_outside_header_in_a_wrong_room_is_found(self):
        self.expect_fault("src/core/bad.cpp:1: core must not include <CL/cl.h>",
                          {"src/core/bad.cpp": "#include <CL/cl.h>\n"})

    def test_file_without_a_room_is_found(self):
        self.expect_fault("src/new/a.cpp:1: is in no room of the table", {"src/new/a.cpp": "\n"})

    def test_exception_allows_one_include(self):
        bad = {"src/core/bad.cpp": '#include "clbvh/trace/tracer.hpp"\n'}
        table = TABLE + "except src/core/bad.cpp include/clbvh/trace/tracer.hpp\n"
        self.assertEqual(run({**FILES, **bad}, table)[0], 0)
        self.expect_fault("table.txt:8: nothing uses this row any more: "
                          "except src/core/bad.cpp include/clbvh/trace/tracer.hpp", table=table)

    def test_stale_rows_are_found(self):
        for row in ("edge tools core", "room gone src/gone", "outside GL/ trace"):
            with self.subTest(row=row):
                self.expect_fault(f"table.txt:8: nothing uses this row any more: {row}", table=TABLE + row + "\n")

    def test_stale_file_behind_only_is_found(self):
        table = TABLE.replace("node.hpp", "node.hpp src/core/gone.hpp")
        self.expect_fault("table.txt:5: nothing uses this row any more: edge trace core only src/core/gone.hpp",
                          table=table)

    def test_cycle_among_rooms_is_found(self):
        status, output = run({**FILES, "src/core/up.cpp": '#include "clbvh/trace/tracer.hpp"\n'},
                             TABLE + "edge core trace\n")
        self.assertEqual(status, 1)
        self.assertIn("a cycle among the table's rooms: trace -> core -> trace", output)

    def test_cycle_among_files_of_one_room_is_found(self):
        self.expect_fault("src/core/a.hpp: a cycle among the files: src/core/a.hpp -> src/core/b.hpp -> src/core/a.hpp",
                          {"src/core/a.hpp": '#include "core/b.hpp"\n', "src/core/b.hpp": '#include "core/a.hpp"\n'})

    def test_full_folder_is_found(self):
        self.assertEqual(run({**FILES, **{f"kernels/{i}.cl": "\n" for i in range(40)}})[0], 0)
        self.expect_fault("kernels: 41 files, at most 40 belong into a folder",
                          {f"kernels/{i}.cl": "\n" for i in range(41)})

    def test_torn_row_is_found(self):
        self.expect_fault("table.txt:8: expected room, edge, outside or except, a name, and what follows it",
                          table=TABLE + "edge core\n")

    def test_matrix_is_printed(self):
        self.assertEqual(run(FILES, TABLE, "--matrix"), (0, "core   -\ntools  trace 1\ntrace  core 1\n"))


if __name__ == "__main__":
    unittest.main()
