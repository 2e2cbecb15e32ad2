"""Debian 12's packages with compilers for GPUs, unpacked where nothing else finds them: OpenCL's loader would take an
installed driver for a device."""
import glob
import os
import subprocess

# clang-19 is to be installed. ocloc wants the libraries of its own LLVM.
PACKAGES = ["libclc-19", "rocm-device-libs", "intel-opencl-icd", "libigc1", "libigdfcl1", "libigdgmm12",
            "libopencl-clang14", "libllvmspirvlib14", "libclang-cpp14", "libllvm14"]


def unpack(folder):
    """Downloads what is not there yet, and unpacks it."""
    os.makedirs(folder, exist_ok=True)
    wanted = [name for name in PACKAGES if not glob.glob(os.path.join(folder, name + "_*.deb"))]
    if wanted:
        subprocess.run(["apt-get", "download", "-qq", *wanted], cwd=folder, check=True)
    for name in wanted:
        for package in glob.glob(os.path.join(folder, name + "_*.deb")):
            subprocess.run(["dpkg-deb", "-x", package, folder], check=True)
