"""Whether what a kernel hands over to other work groups is fenced, read in a compiler's assembly.

kernels/core/between_groups.clh says what has to be: behind what a work item publishes, a fence of the whole device before
the atomic that announces it; behind that atomic, such a fence before what others have published is observed. Every way
through a kernel is followed, whichever blocks it leads through.
"""
import re
from collections import namedtuple

# What an instruction is to the rule; each a regular expression over a line, None where the rule has no use for it.
Dialect = namedtuple("Dialect", "kernel publishes fences announces observes branch end")

PTX = Dialect(
    kernel=re.compile(r"^\s*(?:\.visible\s+)?\.entry\s+(\w+)"),
    publishes=re.compile(r"\bst\.(volatile|relaxed)\."),
    fences=re.compile(r"\b(fence\.(acq_rel|sc)\.(gpu|sys)|membar\.(gl|sys))\s*;"),
    # Exchanges, and subtractions, which libclc writes as additions of what it has negated. Counters only go up.
    announces=re.compile(r"\batom\.(relaxed\.gpu\.)?global\.(exch|add\.u32\s+%r\d+, \[[^]]*\], temp)"),
    observes=re.compile(r"\bld\.(volatile|relaxed\.gpu)\."),
    branch=re.compile(r"^\s*(@!?%p\d+\s+)?bra(?:\.uni)?\s+(\S+?);"),
    end=re.compile(r"^\s*(ret|exit)\s*;"),
)

# A relaxed store looks like any other, so that all of them count. Atomics whose result is used have `glc`.
AMD = Dialect(
    kernel=re.compile(r"^(\w+):\s*; @\1"),
    publishes=re.compile(r"^\s*(global|flat)_store_"),
    fences=re.compile(r"^\s*(buffer_wbinvl1_vol|buffer_gl1_inv)\b"),
    announces=re.compile(r"^\s*(global|flat)_atomic_(swap|sub|dec)(_\w+)? .*\bglc\b"),
    observes=re.compile(r"^\s*(global|flat)_load_\w+ .*\bglc\b"),
    branch=re.compile(r"^\s*s_(c)?branch(?:_\w+)?\s+(\S+)"),
    end=re.compile(r"^\s*s_endpgm"),
)

LABEL = re.compile(r"^(\$?[\w.$]+):")
UNRELEASED, UNACQUIRED = 1, 2  # published and not fenced; announced and not fenced


def kernels_of(text, dialect):
    """Name and lines of each kernel."""
    found, lines = [], None
    for line in text.splitlines():
        begin = dialect.kernel.match(line)
        if begin:
            lines = []
            found.append((begin.group(1), lines))
        elif lines is not None:
            lines.append(line)
    return found


class Blocks:
    """A kernel's lines, cut where control flow parts or meets. `next` has each block's followers."""

    def __init__(self, lines, dialect):
        self.lines, self.next = [[]], [set()]
        at, branches = {}, []
        for line in lines:
            label = LABEL.match(line)
            if label:
                self._begin(falls_through=True)
                at[label.group(1)] = len(self.lines) - 1
                continue
            self.lines[-1].append(line)
            branch = dialect.branch.match(line)
            if branch:
                branches.append((len(self.lines) - 1, branch.group(2)))
                self._begin(falls_through=bool(branch.group(1)))
            elif dialect.end.match(line):
                self._begin(falls_through=False)
        for block, label in branches:
            self.next[block].add(at[label])

    def _begin(self, falls_through):
        if falls_through:
            self.next[-1].add(len(self.lines))
        self.lines.append([])
        self.next.append(set())


def pass_through(lines, state, dialect, faults):
    """The state behind `lines`; what they do against the rule goes to `faults`."""
    for line in lines:
        if dialect.fences.search(line):
            state = 0
        elif dialect.announces.search(line):
            if state & UNRELEASED:
                faults.add("announced without a fence: " + line.strip())
            state |= UNACQUIRED
        elif dialect.publishes.search(line):
            state |= UNRELEASED
        elif dialect.observes.search(line) and state & UNACQUIRED:
            faults.add("observed without a fence: " + line.strip())
    return state


def fence_faults(lines, dialect):
    """What a kernel hands over without a fence, sorted; empty where all is well."""
    blocks, faults = Blocks(lines, dialect), set()
    before = [0] * len(blocks.lines)
    waiting = list(range(len(blocks.lines)))
    while waiting:
        block = waiting.pop()
        after = pass_through(blocks.lines[block], before[block], dialect, faults)
        for follower in blocks.next[block]:
            if after | before[follower] != before[follower]:
                before[follower] |= after
                waiting.append(follower)
    return sorted(faults)


def hands_over(lines, dialect):
    """Whether the kernel announces anything, and fences it at all."""
    return any(map(dialect.announces.search, lines)), any(map(dialect.fences.search, lines))
