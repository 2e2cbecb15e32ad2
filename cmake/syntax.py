#!/usr/bin/env python3
"""Lets a compiler read the sources that no build has compiled yet, each for itself, without making objects of them.

    cmake/syntax.py FOLDER [OTHER_FOLDER...]

The commands are those of FOLDER, which is configured with CMAKE_EXPORT_COMPILE_COMMANDS and without precompiled headers.
Left out is what FOLDER or another folder has compiled. Warnings that need optimised code are not seen.
"""
import concurrent.futures
import json
import os
import pathlib
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def commands_of(folder):
    with open(folder / "compile_commands.json", encoding="utf-8") as file:
        return json.load(file)


def is_own(source):
    """Files that CMake generated lie in build folders."""
    path = pathlib.Path(source)
    return path.is_relative_to(ROOT) and not path.relative_to(ROOT).parts[0].startswith("build")


def is_compiled(command):
    arguments = shlex.split(command["command"])
    return os.path.exists(os.path.join(command["directory"], arguments[arguments.index("-o") + 1]))


def compiled_sources(folders):
    return {command["file"] for folder in folders for command in commands_of(folder) if is_compiled(command)}


def reads(command):
    """Whether the compiler has nothing to say about the file; else prints what it says."""
    arguments = shlex.split(command["command"])
    output = arguments.index("-o")
    del arguments[output:output + 2]
    arguments[arguments.index("-c")] = "-fsyntax-only"
    result = subprocess.run(arguments, cwd=command["directory"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            text=True, check=False)
    print(result.stdout, end="", flush=True)
    return result.returncode == 0


def main(folders):
    folders = [pathlib.Path(folder).resolve() for folder in folders]
    compiled = compiled_sources(folders)
    todo = {command["file"]: command for command in commands_of(folders[0])
            if is_own(command["file"]) and command["file"] not in compiled}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        faulty = [file for file, fine in zip(todo, pool.map(reads, todo.values())) if not fine]
    print(f"syntax: {len(todo)} files, {len(faulty)} faulty")
    for file in faulty:
        print(f"  {os.path.relpath(file, ROOT)}")
    return 1 if faulty else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1:]))
