"""Groups of panels that are chosen at once: strips, or pieces of long ones.

Along a strip a panel's ends follow its own rulings, which ties neighbours more than a common edge
does: a strip with its ends solved exactly leaves little to its neighbours.
"""

from __future__ import annotations

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


def matchings_of(groups: Sequence[IntArray], joints: Joints, count: int = 2) -> list[IntArray]:
    """Pairs (n, 2) of groups that joints connect, each group in one of them at most (greedy).

    Parameters
    ----------
    count : int
        Number of matchings; no pair is in two of them.
    """
    label = np.full(int(joints.panels.max(initial=0)) + 1, -1, dtype=np.int64)
    for k, group in enumerate(groups):
        label[group] = k
    pairs = np.unique(np.sort(label[joints.panels], axis=1), axis=0)
    left = [(a, b) for a, b in pairs.tolist() if a != b and a >= 0]
    out = []
    for _ in range(count):
        taken: set[int] = set()
        found = []
        for a, b in left:
            if a not in taken and b not in taken:
                taken |= {a, b}
                found.append((a, b))
        left = [pair for pair in left if pair not in set(found)]
        if found:
            out.append(np.array(found))
    return out
