#!/usr/bin/env python3
"""Checks that a shared library exports what its public headers declare, and nothing else.

    exported_symbols.py LIBRARY HEADER_FOLDER... [--nm NM]

Each exported symbol must be a name of namespace clbvh, or a function clbvh_..., that stands in a header. Private
namespaces (clbvh::device, clbvh::host, ...) and implementation types (State) stand in headers at most as declarations,
and are faults. So is what templates of other libraries than the standard one leave behind. Every function of the C
interface in those headers must be there. Exit status 1 and one line a fault.
"""
import argparse
import pathlib
import re
import subprocess
import sys

PRIVATE_NAMESPACES = {"device", "host", "io", "optimizer", "trace", "(anonymous namespace)"}
# Templates of the standard library are exported wherever they are instantiated: their namespace says so.
STANDARD = re.compile(r"(\w+ )?(std|__gnu_cxx)::")
# What the compiler makes for a class: Error is thrown through the library's boundary.
FOR_CLASS = re.compile(r"^(vtable|typeinfo|typeinfo name) for ")
C_FUNCTION = re.compile(r"_API\s[^;{]*?\b(clbvh_\w+)\(", re.S)


def read_headers(folders):
    """The text of all headers, without comments."""
    texts = []
    for folder in folders:
        path = pathlib.Path(folder)
        for file in sorted(path.rglob("*.h*")) if path.is_dir() else [path]:
            texts.append(re.sub(r"//[^\n]*|/\*.*?\*/", "", file.read_text(encoding="utf-8"), flags=re.S))
    return "\n".join(texts)


def exported_symbols(nm, library):
    lines = subprocess.run([nm, "-D", "--defined-only", "-C", library], check=True, capture_output=True,
                           text=True).stdout.splitlines()
    return [line.split(" ", 2)[2] for line in lines if len(line.split(" ", 2)) == 3]


def name_of(symbol):
    """The qualified name in a demangled symbol: without arguments, ABI tags and what stands before it."""
    symbol = re.sub(r"\[abi:\w+\]", "", FOR_CLASS.sub("", symbol))
    symbol = symbol.replace("operator()", "operator_call")
    return symbol.replace("(anonymous namespace)", "<anonymous>").split("(")[0].replace(
        "<anonymous>", "(anonymous namespace)")


def fault_of(symbol, words):
    """What is wrong with the symbol, or None."""
    name = name_of(symbol)
    if name.startswith("clbvh_"):
        return None if name in words else "stands in no public header"
    if STANDARD.match(name):
        return None
    if not name.startswith("clbvh::"):
        return "is no name of clbvh"
    parts = name.split("::")[1:]
    if parts[0] in PRIVATE_NAMESPACES or "State" in parts:
        return "is private"
    missing = [part for part in parts if part.lstrip("~").split("<")[0] not in words and "operator" not in part]
    return f"has the part {missing[0]}, which stands in no public header" if missing else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shared_object")
    parser.add_argument("headers", nargs="+")
    parser.add_argument("--nm", default="nm")
    arguments = parser.parse_args()

    text = read_headers(arguments.headers)
    words = set(re.findall(r"\w+", text))
    symbols = exported_symbols(arguments.nm, arguments.shared_object)
    faults = [f"{symbol}: {fault}" for symbol in symbols if (fault := fault_of(symbol, words))]
    faults += [f"{name}: declared in the C interface and not exported"
               for name in sorted(set(C_FUNCTION.findall(text)) - set(symbols))]
    if not symbols:
        faults.append("the library exports nothing")
    print("\n".join(faults) or f"{len(symbols)} exported symbols, all of them public")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
