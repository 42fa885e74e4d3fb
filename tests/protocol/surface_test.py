#!/usr/bin/env python3
"""Laws of the decoder's surfaces, of either rule: as many nodes as halving all edges makes, a slot for each, and parents and
children that name each other."""

import random
import sys
import unittest

from surface import Surface

BASES = {
    "triangle": [0, 1, 2],
    "tetrahedron": [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2],
    "octahedron": [0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1, 5, 2, 1, 5, 3, 2, 5, 4, 3, 5, 1, 4],
    "tube": [0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 2, 0, 3, 2, 3, 5],
}


def shuffled(corners, seed):
    """With faces in another order and other corners first, so that every side meets every other."""
    rng = random.Random(seed)
    faces = [corners[i:i + 3] for i in range(0, len(corners), 3)]
    rng.shuffle(faces)
    return [v for face in faces for turn in [rng.randrange(3)] for v in face[turn:] + face[:turn]]


def surface_of(corners, rule, halvings):
    vertices, faces = max(corners) + 1, len(corners) // 3
    base = [0] * 3 * (vertices + (faces if rule else 0))
    return Surface({"rule": rule, "halvings": halvings, "vertices": vertices, "faces": corners, "base": base, "quantum_m": 1.0,
                    "atlas_side": 0, "pose_epochs": None, "base_moves": None}, 0, 0)


def all_slots(surface):
    slots, todo = set(surface.first_level), list(surface.first_level)
    while todo:
        new = set(surface.children(todo.pop())) - slots
        slots |= new
        todo += new
    return slots


def node_count(corners, rule, halvings):
    """By Euler: halving all edges adds a vertex for each edge."""
    faces = len(corners) // 3
    edges = len({frozenset((corners[i], corners[i + 1 if i % 3 < 2 else i - 2])) for i in range(len(corners))})
    if rule:
        faces, edges = 3 * faces, edges + 3 * faces
    nodes = 0
    for _ in range(halvings):
        nodes, edges, faces = nodes + edges, 2 * edges + 3 * faces, 4 * faces
    return nodes


CASES = [(name, seed, rule) for name in BASES for seed in range(4) for rule in (0, 1)]


class Surfaces(unittest.TestCase):
    def test_each_node_has_a_slot_of_its_level(self):
        for name, seed, rule in CASES:
            corners = shuffled(BASES[name], seed)
            surface = surface_of(corners, rule, 3)
            slots = all_slots(surface)
            self.assertEqual(len(slots), node_count(corners, rule, 3), (name, seed, rule))
            self.assertEqual(len({surface.nodes[s].name for s in slots}), len(slots))
            for slot in slots:
                level = surface.nodes[slot].level
                self.assertIn(slot, range(surface.offset[level], surface.offset[level + 1]))

    def test_parents_and_children_name_each_other(self):
        for name, seed, rule in CASES:
            surface = surface_of(shuffled(BASES[name], seed), rule, 3)
            for slot in all_slots(surface):
                n = surface.nodes[slot]
                self.assertEqual(n.level == 1, not n.parents, (name, seed, rule))
                for parent in n.parents:
                    self.assertEqual(surface.nodes[parent].level, n.level - 1)
                    self.assertIn(slot, surface.children(parent), (name, seed, rule))
                for child in surface.children(slot):
                    self.assertIn(slot, surface.nodes[child].parents, (name, seed, rule))


if __name__ == "__main__":
    sys.exit(unittest.main())
