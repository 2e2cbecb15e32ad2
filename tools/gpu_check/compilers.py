"""Compiles a kernel file for a GPU, without one, and reads what came of it."""
import os
import re
import shutil
import struct
import subprocess

from . import assembly
from .targets import Kernel

WARNINGS = ["-Wno-linker-warnings", "-Wno-override-module"]
# NVIDIA's OpenCL has these, of which neither clang nor libclc knows.
NVIDIA_EXTENSIONS = ["-Xclang", "-cl-ext=+cl_khr_int64_base_atomics,+cl_khr_int64_extended_atomics",
                     "-Datom_min(p, v)=__atomic_fetch_min(p, v, __ATOMIC_RELAXED)"]
AMD_LIBRARIES = ["opencl", "ocml", "ockl", "oclc_finite_only_off", "oclc_correctly_rounded_sqrt_on", "oclc_daz_opt_off",
                 "oclc_unsafe_math_off", "oclc_abi_version_500"]


class CompileError(Exception):
    pass


def run(command, **options):
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise CompileError(done.stdout + done.stderr + "by " + " ".join(command))
    return done.stdout + done.stderr


class Tools:
    """What is installed, or unpacked below `root`, as Debian's packages have it."""

    def __init__(self, root):
        self.root = root or "/"
        self.clang = next(filter(None, map(shutil.which, (f"clang-{v}" for v in range(22, 14, -1)))), None)
        self.nvidia_library = self._find("usr/lib/clc/nvptx64--nvidiacl.bc")
        self.amd_libraries = self._find("usr/lib/x86_64-linux-gnu/amdgcn/bitcode")
        self.ocloc = self._find("usr/bin/ocloc")
        self.ptxas = shutil.which("ptxas") or next(filter(os.path.exists, ["/usr/local/cuda/bin/ptxas"]), None)

    def _find(self, path):
        for root in (self.root, "/"):
            if os.path.exists(os.path.join(root, path)):
                return os.path.join(root, path)
        return None

    def missing(self, vendor):
        """What a vendor's GPUs cannot be compiled for without."""
        needs = {"nvidia": [("clang-15 or newer", self.clang), ("libclc of the same version", self.nvidia_library)],
                 "amd": [("clang-15 or newer", self.clang), ("rocm-device-libs", self.amd_libraries)],
                 "intel": [("intel-opencl-icd (ocloc)", self.ocloc)]}
        return [name for name, found in needs[vendor] if not found]


class Job:
    """One program of one GPU. `source` is a file, `options` those of clBuildProgram."""

    def __init__(self, target, file, group, options, source, folder):
        self.target, self.file, self.group = target, file, group
        self.options, self.source, self.folder = options, source, folder

    @property
    def title(self):
        return f"{self.target.name}: {self.file} {self.options}"

    def path(self, name):
        return os.path.join(self.folder, name)


def clang_command(tools, job, more):
    return [tools.clang, "-x", "cl", "-O3", *WARNINGS, *job.options.split(), *more, job.source]


def link(*libraries):
    return [word for library in libraries for word in ("-Xclang", "-mlink-builtin-bitcode", "-Xclang", library)]


def read_fences(kernels, text, dialect):
    for name, lines in assembly.kernels_of(text, dialect):
        if name in kernels:
            kernels[name].faults = assembly.fence_faults(lines, dialect)
            kernels[name].announces, kernels[name].has_fence = assembly.hands_over(lines, dialect)


def compile_nvidia(tools, job):
    ptx = job.path("a.ptx")
    run(clang_command(tools, job, [
        "-target", "nvptx64-nvidia-nvcl", *NVIDIA_EXTENSIONS, "-Xclang", "-target-cpu", "-Xclang", job.target.name, "-Xclang", "-target-feature",
        "-Xclang", "+ptx78", *link(tools.nvidia_library), "-S", "-o", ptx]))
    with open(ptx, encoding="utf-8") as file:
        text = file.read()
    kernels = {name: Kernel(name, job.group) for name, _ in assembly.kernels_of(text, assembly.PTX)}
    read_fences(kernels, text, assembly.PTX)
    for name, size in re.findall(r"^\s*\.shared .*?\b(\w+?)_\$_\w+\[(\d+)\];", text, re.M):
        kernels[name].local += int(size)
    if tools.ptxas:
        # OpenCL's compiler knows the size of a group from the kernel's attribute; clang does not pass it on.
        with open(ptx, "w", encoding="utf-8") as file:
            file.write(re.sub(r"(\.entry \w+\(.*?\n\)\n)", rf"\1.reqntid {job.group}, 1, 1\n", text, flags=re.S))
        report = run([tools.ptxas, f"-arch={job.target.name}", "-v", ptx, "-o", job.path("a.cubin")])
        read_ptxas(kernels, report)
    return kernels


def read_ptxas(kernels, report):
    for part in report.split("Compiling entry function")[1:]:
        kernel = kernels[re.search(r"'(\w+)'", part).group(1)]
        stack, stores, loads = map(int, re.search(
            r"(\d+) bytes stack frame, (\d+) bytes spill stores, (\d+) bytes spill loads", part).groups())
        kernel.private, kernel.spills = stack, stores + loads
        kernel.registers = int(re.search(r"Used (\d+) registers", part).group(1))
        local = re.search(r"(\d+) bytes smem", part)
        kernel.local = int(local.group(1)) if local else 0


def amd_library_of(tools, name):
    """The library of a processor; of one that is newer than the libraries, that of the newest of its kind."""
    own = os.path.join(tools.amd_libraries, f"oclc_isa_version_{name.removeprefix('gfx')}.bc")
    return own if os.path.exists(own) else os.path.join(tools.amd_libraries, "oclc_isa_version_1036.bc")


def compile_amd(tools, job):
    wide = "on" if job.target.name.startswith("gfx9") else "off"
    libraries = [os.path.join(tools.amd_libraries, name + ".bc")
                 for name in [*AMD_LIBRARIES, "oclc_wavefrontsize64_" + wide]]
    text_path = job.path("a.s")
    report = run(clang_command(tools, job, [
        "-target", "amdgcn-amd-amdhsa", "-mcpu=" + job.target.name, "-nogpulib", "-Rpass-analysis=kernel-resource-usage",
        *link(*libraries, amd_library_of(tools, job.target.name)), "-S", "-o", text_path]))
    kernels = {}
    for part in report.split("Function Name: ")[1:]:
        values = {what: int(value) for what, value in re.findall(r": +([A-Z][\w /\[\]]*): (\d+)", part)}
        kernel = Kernel(re.match(r"\w+", part).group(0), job.group)
        kernels[kernel.name] = kernel
        kernel.registers, kernel.private = values["VGPRs"], values["ScratchSize [bytes/lane]"]
        kernel.waves, kernel.local = values["Occupancy [waves/SIMD]"], values["LDS Size [bytes/block]"]
        kernel.spills = values["VGPRs Spill"]  # those of scalars go to registers
    with open(text_path, encoding="utf-8") as file:
        read_fences(kernels, file.read(), assembly.AMD)
    return kernels


def section_of(data, wanted):
    """A section of a 64-bit ELF file."""
    begin, = struct.unpack_from("<Q", data, 0x28)
    size, count, names = struct.unpack_from("<HHH", data, 0x3A)
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, begin + size * i) for i in range(count)]
    for section in sections:
        at = sections[names][4] + section[0]
        if data[at:data.index(b"\0", at)].decode() == wanted:
            return data[section[4]:section[4] + section[5]].decode()
    raise CompileError("no section " + wanted)


def compile_intel(tools, job):
    folders = [os.path.join(tools.root, "usr/lib/x86_64-linux-gnu" + sub) for sub in ("", "/intel-opencl")]
    environment = dict(os.environ, LD_LIBRARY_PATH=":".join(folders))
    report = run([tools.ocloc, "compile", "-file", job.source, "-device", job.target.name, "-options", job.options,
                  "-internal_options", "-cl-intel-allow-zebin -cl-intel-enable-zebin", "-out_dir", job.folder, "-output", "a",
                  "-output_no_suffix"], env=environment)
    if not os.path.exists(job.path("a")):
        raise CompileError(report)
    with open(job.path("a"), "rb") as file:
        text = section_of(file.read(), ".ze_info")
    kernels = {}
    for part in re.split(r"^  - name: +", text.split("kernels_misc_info:")[0], flags=re.M)[1:]:
        name = re.match(r"\w+", part).group(0)
        if name.startswith("Intel_"):
            continue
        values = {what: int(value) for what, value in re.findall(r"(\w+): +(\d+)$", part, re.M)}
        kernel = kernels[name] = Kernel(name, job.group)
        kernel.registers, kernel.lanes = values["grf_count"], values["simd_size"]
        kernel.local = values.get("slm_size", 0)
        kernel.private = sum(map(int, re.findall(r"usage: +private_space\n +size: +(\d+)", part)))
    for name, registers in re.findall(r"kernel (\w+) +compiled SIMD\d+ allocated \d+ regs and spilled around (\d+)", report):
        kernels[name].spills = 32 * int(registers)
    return kernels


COMPILE = {"nvidia": compile_nvidia, "amd": compile_amd, "intel": compile_intel}
