"""Groups of panels that are chosen at once: strips, or pieces of long ones.

Along a strip a panel's ends follow its own rulings, which ties neighbours more than a common edge
does: a strip with its ends solved exactly leaves little to its neighbours.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from fabgeo.arrays import IntArray
from fabgeo.panels.joints import Joints

LONGEST = 8  # panels in a group


def strips_of(count: int, joints: Joints, shift: int = 0) -> list[IntArray]:
    """Panels that end rulings connect, in order; where none do, those that edges connect.

    Parameters
    ----------
    count : int
        Number of panels.
    shift : int
        Long strips are cut into pieces of at most LONGEST panels, the first one shorter by this.
    """
    use = joints.panels[joints.ends] if joints.ends.any() else joints.panels
    links = np.concatenate([use, use[:, ::-1]])
    graph = csr_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    degree = np.bincount(links[:, 0], minlength=count)
    order = np.lexsort((degree, label))  # a strip's ends come first
    firsts = order[np.flatnonzero(np.diff(label[order], prepend=-1))]
    out: list[IntArray] = []
    for first in firsts:
        chain = breadth_first_order(graph, int(first), directed=False, return_predecessors=False)
        chain = chain.astype(np.int64)
        begin = LONGEST - shift if shift and len(chain) > LONGEST else 0
        cuts = range(begin, len(chain), LONGEST) if begin else range(LONGEST, len(chain), LONGEST)
        out += np.split(chain, list(cuts))
    return [group for group in out if len(group)]


def colours_of(groups: Sequence[IntArray], joints: Joints) -> IntArray:
    """Colours of groups, different across every joint (greedy)."""
    label = np.full(int(joints.panels.max(initial=0)) + 1, -1, dtype=np.int64)
    for k, group in enumerate(groups):
        label[group] = k
    beside: list[set[int]] = [set() for _ in groups]
    for a, b in label[joints.panels].tolist():
        if a != b and a >= 0 and b >= 0:
            beside[a].add(b)
            beside[b].add(a)
    colour = np.full(len(groups), -1, dtype=np.int64)
    for k in range(len(groups)):
        taken = {int(colour[other]) for other in beside[k]}
        colour[k] = next(c for c in range(len(groups)) if c not in taken)
    return colour


def windows_of(
    groups: Sequence[IntArray], joints: Joints, count: int, shift: int = 0
) -> list[IntArray]:
    """Windows of neighbouring groups, each group in one of them at most; numbers of groups.

    Groups are lined up, each beside the one that it shares most joints with, and the lines cut.

    Parameters
    ----------
    count : int
        Groups in a window, two at least; fewer at the ends of lines.
    shift : int
        Groups before the first cut; where a line is closed none are left over at its ends.
    """
    label = np.full(int(joints.panels.max(initial=0)) + 1, -1, dtype=np.int64)
    for k, group in enumerate(groups):
        label[group] = k
    shared: list[Counter[int]] = [Counter() for _ in groups]
    for a, b in label[joints.panels].tolist():
        if a != b and a >= 0 and b >= 0:
            shared[a][b] += 1
            shared[b][a] += 1
    free, out = set(range(len(groups))), []
    while free:
        line = [min(free, key=lambda k: (len(shared[k]), k))]
        free.remove(line[0])
        while beside := [k for k in shared[line[-1]] if k in free]:
            line.append(max(beside, key=lambda k: (shared[line[-1]][k], -k)))
            free.remove(line[-1])
        closed = len(line) > 2 and line[0] in shared[line[-1]]
        if closed:
            line = line[shift:] + line[:shift]
        begin = count if closed or not shift else shift
        out += np.split(np.array(line), range(begin, len(line), count))
    return [window for window in out if len(window) > 1]
