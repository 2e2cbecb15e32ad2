#!/usr/bin/env python3
"""Whether tools/check_gpus sees what is wrong: check_gpus_test.py LIST_GPU_PROGRAMS [TOOLS]

The rule about fences is tried on assembly; all of it on kernels that are made wrong on purpose, by the compilers that are
there.
"""
import os
import re
import subprocess
import sys
import tempfile
import unittest

TOOLS_FOLDER = os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../tools")
sys.path.insert(0, TOOLS_FOLDER)
from gpu_check import compilers  # noqa: E402
from gpu_check.assembly import AMD, PTX, fence_faults, kernels_of  # noqa: E402
from gpu_check.targets import TARGETS, Kernel  # noqa: E402

LIST_PROGRAMS, TOOLS = (sys.argv[1:] + [None, None])[:2]

LOOP = """
.entry climb(
)
{
$L__BB0_1:
    setp.eq.s32 %p1, %r1, 0;
    @%p1 bra $L__BB0_3;
    st.volatile.global.u32 [%rd1], %r1;
    FIRST
    atom.global.exch.b32 %r2, [%rd2], %r1;
    @%p2 bra $L__BB0_3;
    SECOND
    ld.volatile.global.u32 %r3, [%rd1];
    bra.uni $L__BB0_1;
$L__BB0_3:
    ret;
}
"""
FENCE = "fence.acq_rel.gpu;"


def faults_of_loop(first, second):
    (_, lines), = kernels_of(LOOP.replace("FIRST", first).replace("SECOND", second), PTX)
    return [fault.split(":")[0] for fault in fence_faults(lines, PTX)]


class Fences(unittest.TestCase):
    def test_both_are_needed(self):
        self.assertEqual(faults_of_loop(FENCE, FENCE), [])
        self.assertEqual(faults_of_loop("", FENCE), ["announced without a fence"])
        self.assertEqual(faults_of_loop(FENCE, ""), ["observed without a fence"])
        self.assertEqual(len(faults_of_loop("", "")), 2)

    def test_a_fence_of_the_work_group_is_none(self):
        for weak in ("fence.acq_rel.cta;", "membar.cta;", "bar.sync 0;"):
            self.assertEqual(len(faults_of_loop(weak, weak)), 2, weak)
        for strong in ("membar.gl;", "membar.sys;", "fence.sc.gpu;"):
            self.assertEqual(faults_of_loop(strong, strong), [], strong)

    def test_every_way_is_followed(self):
        around = FENCE.join(["@%p3 bra $L__BB0_2;\n", "\n$L__BB0_2:"])
        self.assertEqual(faults_of_loop(around, FENCE), ["announced without a fence"])
        self.assertEqual(faults_of_loop(FENCE, around), ["observed without a fence"])

    def test_a_wait_and_a_fence_of_the_group_are_none_on_amd(self):
        text = "climb:   ; @climb\n global_store_dword v0, v1, off\n WAIT\n" \
               " global_atomic_swap v2, v[0:1], v3, off glc\n WAIT\n global_load_dword v4, v[0:1], off glc\n s_endpgm\n"
        counts = {"buffer_wbinvl1_vol": 0, "buffer_gl1_inv": 0, "buffer_gl0_inv": 2, "s_waitcnt vmcnt(0)": 2}
        for fence, count in counts.items():
            (_, lines), = kernels_of(text.replace("WAIT", fence), AMD)
            self.assertEqual(len(fence_faults(lines, AMD)), count, fence)


class Occupancy(unittest.TestCase):
    def occupancy(self, name, registers, group, local):
        kernel = Kernel("k", group)
        kernel.registers, kernel.local = registers, local
        return {target.name: target for target in TARGETS}[name].occupancy(kernel)

    def test_nvidia(self):
        self.assertEqual(self.occupancy("sm_90", 32, 256, 0), 1.0)
        self.assertEqual(self.occupancy("sm_90", 33, 1024, 0), 0.5)
        self.assertEqual(self.occupancy("sm_90", 16, 32, 0), 0.5)  # 32 groups at most
        self.assertEqual(self.occupancy("sm_90", 16, 256, 48000), 0.5)  # four of 47.9 KiB
        self.assertEqual(self.occupancy("sm_75", 64, 256, 0), 1.0)


class WrongKernels(unittest.TestCase):
    """Each folder has one program that is wrong."""

    def programs(self, file, group, change):
        if not LIST_PROGRAMS:
            self.skipTest("no list of programs")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        subprocess.run([LIST_PROGRAMS, folder.name], check=True)
        with open(os.path.join(folder.name, file), encoding="utf-8") as source:
            text = source.read()
        changed = change(text)
        self.assertNotEqual(changed, text)
        with open(os.path.join(folder.name, file), "w", encoding="utf-8") as source:
            source.write(changed)
        path = os.path.join(folder.name, "programs.tsv")
        with open(path, encoding="utf-8") as listed:
            lines = [line for line in listed if line.split("\t")[1] == file and line.split("\t")[3] == "default"]
        if group:
            lines = [re.sub(r"\t\d+\t(.*WORK_GROUP_SIZE=)\d+", rf"\t{group}\t\g<1>{group}", line) for line in lines]
        with open(path, "w", encoding="utf-8") as listed:
            listed.writelines(lines)
        return folder.name

    def check(self, folder, targets):
        return subprocess.run([os.path.join(TOOLS_FOLDER, "check_gpus"), folder, "--targets", ",".join(targets),
                               *(["--tools", TOOLS] if TOOLS else [])], capture_output=True, text=True)

    def expect(self, message, file, change, targets, group=None):
        found = compilers.Tools(TOOLS)
        vendors = {target.name: target.vendor for target in TARGETS}
        there = [name for name in targets if not found.missing(vendors[name])]
        if message.startswith("spills") and not found.ptxas:
            there = [name for name in there if vendors[name] != "nvidia"]
        if not there or not LIST_PROGRAMS:
            self.skipTest("no compilers for " + ", ".join(targets))
        done = self.check(self.programs(file, group, change), there)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        for name in there:
            self.assertRegex(done.stdout, f"FAILED {name}:.*\n.*(\n.*)?{message}", done.stderr)

    def test_removed_fences(self):
        announcing = ["sm_90", "gfx90a", "gfx1100"]
        for file, kernel in (("lbvh.cl", "climb_boxes"), ("refit.cl", "fit_inner"), ("depth_first.cl", "measure"),
                             ("hploc.cl", "climb_clusters"), ("reinsert_refit.cl", "refit_changes")):
            with self.subTest(file):
                self.expect(f"{kernel}.*fence", file, lambda text: re.sub(r"^\s+DEVICE_FENCE\(\);\n", "\n", text, flags=re.M),
                            announcing)

    def test_first_and_second_fence(self):
        def without(number):
            def change(text):
                places = [m.span() for m in re.finditer(r"^ +DEVICE_FENCE\(\);", text, re.M)]
                begin, end = places[number]
                return text[:begin] + text[end:]
            return change
        self.expect("climb_boxes: announced without", "lbvh.cl", without(0), ["sm_90", "gfx90a", "gfx1100"])
        self.expect("climb_boxes: observed without", "lbvh.cl", without(1), ["sm_90", "gfx90a", "gfx1100"])

    def test_fence_of_the_work_group(self):
        weak = "#undef DEVICE_FENCE\n#define DEVICE_FENCE() mem_fence(CLK_GLOBAL_MEM_FENCE)\n#define NOT_REACHED"
        self.expect("climb_boxes.*fence", "lbvh.cl", lambda text: text.replace("#define NOT_REACHED", weak),
                    ["sm_90", "gfx90a", "gfx1100"])

    def test_too_much_local_memory(self):
        self.expect("local memory|smem|exceeds", "root.cl", lambda text: text + """
kernel __attribute__((reqd_work_group_size(WORK_GROUP_SIZE, 1, 1))) void large(global uint* out) {
    local uint all[12500 + 4500];
    for (uint i = get_local_id(0); i < 17000; i += WORK_GROUP_SIZE) all[i] = out[i];
    barrier(CLK_LOCAL_MEM_FENCE);
    out[get_global_id(0)] = all[16999 - get_local_id(0)];
}
""", ["sm_90", "sm_75", "gfx90a", "gfx1100"])

    def test_spills(self):
        of_all = range(150)
        many = ", ".join(f"r{i} = in[{i} * n]" for i in of_all)
        mixed = " ".join(f"r{i} = r{i} * r{(i * 7 + 3) % 150} + r{(i * 11 + 5) % 150};" for i in of_all)
        total = " + ".join(f"r{i}" for i in of_all)
        self.expect("spills", "root.cl", lambda text: text + f"""
kernel __attribute__((reqd_work_group_size(WORK_GROUP_SIZE, 1, 1))) void wide(global const float* in, uint n, global float* out) {{
    in += get_global_id(0);
    float {many};
    for (uint k = 0; k < n; ++k) {{ {mixed} }}
    out[get_global_id(0)] = {total};
}}
""", ["sm_90", "gfx90a", "dg2"], group=1024)

    def test_errors(self):
        self.expect("error", "root.cl", lambda text: text + "\n#error wrong\n", [target.name for target in TARGETS])

    def test_targets_without_compilers_are_named(self):
        done = self.check(self.programs("root.cl", None, lambda text: text + "\n"), ["sm_90"])
        self.assertRegex(done.stdout, "sm_90: (NOT CHECKED, for want of|1 programs)")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]], verbosity=2)
