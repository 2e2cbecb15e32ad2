"""The table of what compilers make of the kernels."""
import subprocess

HEAD = """# What GPU compilers make of the kernels

Every kernel of the group shape with the library's own options, as `tools/check_gpus` compiles it ([gpu](../gpu.md)), without a GPU.
A cell has the registers of a work item (`dg2`: its SIMD width), the local memory of a work group in bytes, private memory of a work item that is not in registers, and the occupancy:
the work items that are resident on a multiprocessor at a time, as part of the most that can be.
No kernel spills more than the few bytes that `KNOWN_SPILLS` of `tools/gpu_check/targets.py` names, and what work groups hand over to each other is fenced.

"""


def versions(tools):
    found = []
    for command in ([tools.clang, "--version"], [tools.ptxas, "--version"]):
        if command[0]:
            lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
            found.append(next(line for line in lines if "version" in line or "release" in line))
    return found


def cell(kernel, target):
    if kernel is None:
        return ""
    occupancy = target.occupancy(kernel)
    parts = [f"SIMD{kernel.lanes}" if kernel.lanes else str(kernel.registers or "?")]
    if kernel.local:
        parts.append(f"{kernel.local} B")
    if kernel.private:
        parts.append(f"private {kernel.private} B")
    if occupancy is not None:
        parts.append(f"{100 * occupancy:.0f} %")
    return ", ".join(parts)


def rows_of(targets, jobs, results):
    """Each kernel of the default programs: its file, its name, and what each GPU makes of it."""
    rows = {}
    for job, (kernels, _) in zip(jobs, results):
        if job.is_default:
            for name, kernel in kernels.items():
                rows.setdefault((job.file, name), {})[job.target.name] = kernel
    return [(file, name, [found.get(target.name) for target in targets]) for (file, name), found in sorted(rows.items())]


def write(path, tools, targets, jobs, results):
    lines = [HEAD + "| file | kernel | " + " | ".join(target.name for target in targets) + " |",
             "|---|---|" + "---|" * len(targets)]
    for file, name, kernels in rows_of(targets, jobs, results):
        cells = [cell(kernel, target) for kernel, target in zip(kernels, targets)]
        lines.append(f"| `{file}` | `{name}` | " + " | ".join(cells) + " |")
    lines += ["", "By " + "; ".join(versions(tools)) + "; the others as Debian 12 has them."]
    with open(path, "w", encoding="utf-8") as page:
        page.write("\n".join(lines) + "\n")
