"""The GPUs, and how much of them a kernel leaves for others: resident work items, as part of what is the most."""
from collections import namedtuple

# local: bytes of local memory that a work group may have.
Target = namedtuple("Target", "name vendor local occupancy")


def multiprocessor(threads, groups, registers, local):
    """NVIDIA: registers are given out to warps in units of 256, local memory to groups in units of 1 KiB, of which one
    is the system's (CUDA C++ Programming Guide, "Compute Capabilities"; the occupancy calculator)."""

    def occupancy(kernel):
        if not kernel.registers:
            return None
        warps = -(-kernel.group // 32)
        of_warp = -(-kernel.registers * 32 // 256) * 256
        fit = [groups, threads // 32 // warps, registers // of_warp // warps]
        fit.append(local // (-(-(kernel.local + 1024) // 1024) * 1024))
        return min(fit) * warps * 32 / threads

    return occupancy


def reported(most):
    """AMD: the compiler says how many waves stay on a SIMD."""
    return lambda kernel: None if kernel.waves is None else kernel.waves / most


def xe_core(kernel):
    """Intel: eight threads of 128 registers an EU, and 16 EUs that share 128 KiB of local memory (Intel, "oneAPI GPU
    Optimization Guide", Xe-core); a thread runs as many work items as its SIMD has lanes."""
    if not kernel.lanes:
        return None
    threads_of_group = -(-kernel.group // kernel.lanes)
    by_threads = 128 // threads_of_group
    by_local = 131072 // kernel.local if kernel.local else by_threads
    return min(1.0, min(by_threads, by_local) * threads_of_group / 128)


TARGETS = [
    Target("sm_90", "nvidia", 49152, multiprocessor(2048, 32, 65536, 233472)),
    Target("sm_75", "nvidia", 49152, multiprocessor(1024, 16, 65536, 65536)),
    Target("gfx90a", "amd", 65536, reported(8)),
    Target("gfx1100", "amd", 65536, reported(16)),
    Target("dg2", "intel", 65536, xe_core),
]

# Bytes that may be spilled: where these few save a register more than a multiple of sixteen, ptxas gives it up for the
# next step of occupancy.
KNOWN_SPILLS = {
    ("sm_90", "batch_triangles"): 24,
    ("sm_90", "recode_runs"): 60,
    ("sm_90", "trace_any"): 16,
    ("sm_75", "recode_at_once"): 32,
    ("sm_75", "write_pieces"): 60,
}


class Kernel:
    """What a compiler made of a kernel. Unknown numbers are None."""

    def __init__(self, name, group):
        self.name, self.group = name, group
        self.registers = self.waves = self.lanes = None
        self.local = self.spills = self.private = 0
        self.faults = []
        self.announces = self.has_fence = False
