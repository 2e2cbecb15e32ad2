#!/usr/bin/env python3
"""Checks every #include of src/, include/ and tools/ against the table of rooms, allowed_edges.txt.

    include_matrix.py [--root FOLDER] [--table FILE]            exit status 1 and one line a fault, each as FILE:LINE: TEXT
    include_matrix.py [--root FOLDER] [--table FILE] --matrix   print who includes whom, and how often

Faults are: an include that no row allows, a cycle among rooms or among files, a file in no room, a row that nothing
uses any more, and a folder of more than 40 files. The table's own comment explains its rows.
"""
import argparse
import collections
import os
import re
import sys

SOURCE_FOLDERS = ("include", "src", "tools")
COUNTED_FOLDERS = ("include", "kernels", "src", "tests", "tools")
MOST_FILES_PER_FOLDER = 40
PUBLIC = "public"
INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^">]+)[">]')


class Include:
    """One #include line: `file` and `line`, the `name` as written, and the `target`, a path, or None outside the project."""

    def __init__(self, file, line, name, target):
        self.file, self.line, self.name, self.target = file, line, name, target

    def fault(self, text):
        return f"{self.file}:{self.line}: {text}"


class Row:
    """One row of the table, which counts how often it is used."""

    def __init__(self, place, words):
        self.place, self.words, self.used = place, words, 0


class Table:
    """The rooms, the edges and the outside headers of a table file."""

    def __init__(self, path):
        self.rooms = {}  # path prefix -> (room, row)
        self.edges = collections.defaultdict(dict)  # room -> {room: row}
        self.only = {}  # (room, room) -> {file: row}
        self.outside = {}  # prefix of a header's name -> {room: row}
        self.exceptions = {}  # (file, included file) -> row
        self.faults = []
        with open(path, encoding="utf-8") as lines:
            for number, line in enumerate(lines, 1):
                words = line.split("#")[0].split()
                if words:
                    self._read(f"{os.path.basename(path)}:{number}", words)

    def _read(self, place, words):
        kind, name, rest = words[0], words[1] if len(words) > 1 else "", words[2:]
        if kind == "room" and rest:
            for prefix in rest:
                self.rooms[prefix] = (name, Row(place, f"room {name} {prefix}"))
        elif kind == "edge" and rest:
            self._read_edge(place, name, rest)
        elif kind == "outside" and rest:
            self.outside[name] = {room: Row(place, f"outside {name} {room}") for room in rest}
        elif kind == "except" and rest:
            self.exceptions.update({(name, target): Row(place, f"except {name} {target}") for target in rest})
        else:
            self.faults.append(f"{place}: expected room, edge, outside or except, a name, and what follows it")

    def _read_edge(self, place, name, rest):
        if "only" not in rest:
            for target in rest:
                self.edges[name][target] = Row(place, f"edge {name} {target}")
            return
        target, files = rest[0], rest[rest.index("only") + 1:]
        self.edges[name][target] = Row(place, f"edge {name} {target}")
        self.only[name, target] = {file: Row(place, f"edge {name} {target} only {file}") for file in files}

    def room_of(self, path):
        """The room of the longest prefix of `path` in the table, or None."""
        prefix = path
        while prefix:
            if prefix in self.rooms:
                room, row = self.rooms[prefix]
                row.used += 1
                return room
            prefix = prefix.rpartition("/")[0]
        return None

    def row_for(self, file, room, target_room, target):
        """The row that allows `file` of `room` to include `target`, or None."""
        if (file, target) in self.exceptions:
            return self.exceptions[file, target]
        only = self.only.get((room, target_room))
        if only is not None and target in only:
            only[target].used += 1
            return self.edges[room][target_room]
        if only is None and target_room in self.edges[room]:
            return self.edges[room][target_room]
        if PUBLIC in self.edges[room] and target.startswith("include/"):
            return self.edges[room][PUBLIC]
        return None

    def stale(self):
        rows = [row for _, row in self.rooms.values()]
        for group in [*self.edges.values(), *self.only.values(), *self.outside.values(), self.exceptions]:
            rows.extend(group.values())
        return [f"{row.place}: nothing uses this row any more: {row.words}" for row in rows if not row.used]


def walk(root, folders):
    """Yields (folder, names) below `root`, sorted, without what Python and editors leave behind."""
    for top in folders:
        for folder, folders_inside, names in os.walk(os.path.join(root, top)):
            folders_inside[:] = sorted(name for name in folders_inside if not name.startswith((".", "__")))
            yield os.path.relpath(folder, root).replace(os.sep, "/"), sorted(n for n in names if not n.startswith("."))


def find_target(files, file, quoted, name):
    """The file that `file` means by `name`, as the compiler finds it, or None for what is not the project's."""
    top = file.split("/")[0]
    folders = ["include"] if top == "include" else ["include", "src", "tools"]
    if quoted:
        folders.insert(0, os.path.dirname(file))
    for folder in folders:
        path = os.path.normpath(f"{folder}/{name}")
        if path in files:
            return path
    return None


def read_includes(root):
    """All includes, and the paths of all files, both in order."""
    files = [f"{folder}/{name}" for folder, names in walk(root, SOURCE_FOLDERS) for name in names]
    known, includes = set(files), []
    for file in files:
        if file.endswith("CMakeLists.txt"):
            continue
        with open(os.path.join(root, file), encoding="utf-8") as lines:
            for number, line in enumerate(lines, 1):
                match = INCLUDE.match(line)
                if match:
                    target = find_target(known, file, match[1] == '"', match[2])
                    includes.append(Include(file, number, match[2], target))
    return includes, [file for file in files if not file.endswith("CMakeLists.txt")]


def check_rooms(table, includes, files):
    faults = []
    rooms = {file: table.room_of(file) for file in files}
    faults.extend(f"{file}:1: is in no room of the table" for file in files if rooms[file] is None)
    for include in includes:
        room = rooms[include.file]
        if include.target is None:
            check_outside(table, include, room, faults)
            continue
        target_room = rooms[include.target]
        if room == target_room or None in (room, target_room):
            continue
        row = table.row_for(include.file, room, target_room, include.target)
        if row is None:
            faults.append(include.fault(f"{room} must not include {include.target} of {target_room}"))
        else:
            row.used += 1
    return faults


def check_outside(table, include, room, faults):
    for prefix, rooms in table.outside.items():
        if include.name.startswith(prefix):
            if room in rooms:
                rooms[room].used += 1
            else:
                faults.append(include.fault(f"{room} must not include <{include.name}>"))


def find_cycle(graph):
    """A cycle of `graph`, a dictionary of lists, as a list that ends where it begins, or None."""
    done, way = set(), []

    def visit(node):
        if node in way:
            return way[way.index(node):] + [node]
        if node in done:
            return None
        way.append(node)
        for following in graph.get(node, ()):
            cycle = visit(following)
            if cycle:
                return cycle
        way.pop()
        done.add(node)
        return None

    for node in list(graph):
        cycle = visit(node)
        if cycle:
            return cycle
    return None


def check_cycles(table, includes):
    faults = []
    public_rooms = sorted({room for prefix, (room, _) in table.rooms.items() if prefix.startswith("include/")})
    rooms = {room: [target for edge in edges for target in (public_rooms if edge == PUBLIC else [edge])]
             for room, edges in table.edges.items()}
    files = collections.defaultdict(list)
    for include in includes:
        if include.target is not None:
            files[include.file].append(include.target)
    for what, graph in (("the table's rooms", rooms), ("the files", files)):
        cycle = find_cycle(graph)
        if cycle:
            faults.append(f"{cycle[0]}: a cycle among {what}: {' -> '.join(cycle)}")
    return faults


def check_folders(root):
    return [f"{folder}: {len(names)} files, at most {MOST_FILES_PER_FOLDER} belong into a folder"
            for folder, names in walk(root, COUNTED_FOLDERS) if len(names) > MOST_FILES_PER_FOLDER]


def print_matrix(table, includes, files):
    rooms = {file: table.room_of(file) for file in files}
    counts = collections.Counter(
        (rooms[i.file], rooms[i.target]) for i in includes if i.target and rooms[i.file] != rooms[i.target])
    names = sorted({str(room) for room in rooms.values()})
    width = max(len(name) for name in names)
    for name in names:
        row = [f"{target} {count}" for (room, target), count in sorted(counts.items(), key=str) if str(room) == name]
        print(f"{name:{width}}  {', '.join(row) or '-'}")


def main(words=None):
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", default=os.path.dirname(os.path.dirname(here)), help="the checkout")
    parser.add_argument("--table", default=os.path.join(here, "allowed_edges.txt"), help="the allowed edges")
    parser.add_argument("--matrix", action="store_true", help="print who includes whom, and check nothing")
    arguments = parser.parse_args(words)

    table = Table(arguments.table)
    includes, files = read_includes(arguments.root)
    if arguments.matrix:
        print_matrix(table, includes, files)
        return 0
    faults = (table.faults + check_rooms(table, includes, files) + table.stale() + check_cycles(table, includes)
              + check_folders(arguments.root))
    print("\n".join(faults) or f"{len(includes)} includes of {len(files)} files: every one is allowed")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
