# SPDX-License-Identifier: GPL-3.0-or-later
"""The hard shapes that must bake well, by name: what test_hard.py holds to its floors and scripts/hard-cases tabulates."""
import math

import hard_meshes as hard
import meshes
import thin_walls as thin

NAN, INF = math.nan, math.inf

# name: (mesh, least PSNR in dB or None, genus and number of borders of the whole or None)
BAKED = {
    "slivers": (lambda: hard.slivers(), 85, (0, 1)),
    "zero_area_faces": (lambda: hard.with_values(meshes.sheet(12), {40: (0.5, 0.5, 0.0), 41: (0.5, 0.5, 0.0)}), 75, None),
    "rounded_to_a_lattice": (lambda: hard.rounded_sheet(), 57, (0, 1)),
    "offset_1e7": (lambda: hard.moved(meshes.icosphere(3), shift=(1e7, -2e7, 3e7)), 80, (0, 0)),
    "tiny_1e-9": (lambda: hard.moved(meshes.torus(), scale=1e-9), 80, (1, 0)),
    "huge_1e9": (lambda: hard.moved(meshes.torus(), scale=1e9), 80, (1, 0)),
    "graded_disk": (lambda: hard.graded_disk(), 100, (0, 1)),
    "finger": (lambda: hard.finger(), 80, (0, 1)),
    "tube_1000_to_1": (lambda: hard.tube(), 75, (0, 2)),
    "spikes": (lambda: hard.spiky_ball(), 55, (0, 0)),
    "tree": (lambda: hard.tree(), 55, (0, 0)),
    "fan_10000": (lambda: hard.fan(), 100, (0, 1)),
    "bipyramid_2000": (lambda: hard.bipyramid(), 70, (0, 0)),
    **{f"genus_{g}": (lambda g=g: hard.plate(g, 2), 68, (g, 0)) for g in range(6)},
    "genus_81": (lambda: hard.lattice_of_bars(), 40, (81, 0)),
    "holes_225": (lambda: hard.sheet_with_holes(), 55, (0, 226)),
    "single_triangle": (lambda: ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]), 100, (0, 1)),
    "two_triangles_folded": (lambda: ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.9, 0.1, 0.1)], [(0, 1, 2), (1, 0, 3)]), 75,
                             (0, 1)),
    "bow_tie": (lambda: hard.bow_tie(), 100, (0, 2)),
    "duplicate_and_opposite": (lambda: hard.with_bad_faces(meshes.icosphere(2)), 80, None),
    "random_winding": (lambda: hard.randomly_wound(meshes.torus()), 80, (1, 0)),
    "unwelded": (lambda: hard.unwelded(meshes.icosphere(2)), 80, (0, 0)),
    "book": (lambda: hard.book(), 100, None),
    "nan_and_inf": (lambda: hard.with_values(meshes.sheet(12), {50: (NAN, 0, 0), 70: (0, INF, 0), 90: (0, 0, -INF)}),
                    40, None),
    "double_sided": (lambda: ([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3), (0, 3, 2, 1)]), None, None),
    "polygon_300": (lambda: ([(math.cos(k / 300 * 2 * math.pi) * (1 + 0.5 * (k % 2)),
                               math.sin(k / 300 * 2 * math.pi) * (1 + 0.5 * (k % 2)), 0) for k in range(300)],
                             [tuple(range(300))]), 100, (0, 1)),
    "two_balls_at_one_vertex": (lambda: hard.cubes([(0, 0, 0), (1, 1, 1)], 2), 70, None),
    "two_bodies_at_one_edge": (lambda: hard.cubes([(0, 0, 0), (1, 1, 0)], 2), 70, None),
}

# Surfaces close to themselves, bodies with many limbs, and charts by the thousand: for scripts/hard-cases, which bounds time and
# memory. Too long for every run of the tests.
CLOSE = {
    **{f"{name}_{gap:g}": (lambda make=make, gap=gap: thin.double_wall(make(), gap))
       for name, make in (("cup", thin.cup), ("cup_of_needles", lambda: thin.cup(sides=1000, needles=True)),
                          ("ribbed", thin.ribbed), ("perforated", thin.perforated), ("roll", thin.roll),
                          ("pleats", thin.pleats), ("ball", thin.ball))
       for gap in (1e-2, 1e-4, 1e-6)},
    **{f"{name}_{copies}_{gap:g}": (lambda make=make, copies=copies, gap=gap: make(copies, gap))
       for name, make in (("stack", thin.stack), ("folded_stack", lambda c, g: thin.stack(c, g, joined=True)),
                          ("shells", thin.shells))
       for copies in (2, 20) for gap in (0, 1e-9, 1e-6, 1e-3)},
    "star_60_points": lambda: hard.star(),
    "comb_20_teeth": lambda: hard.toothed_comb(),
    "gear_30_teeth": lambda: hard.gear(),
    "tree_128_ends": lambda: hard.tree(7),
    "tree_256_ends": lambda: hard.tree(8),
    "soup_1000": lambda: hard.soup(1000),
    "soup_10000": lambda: hard.soup(10000),
    "pages_5000": lambda: hard.book(5000),
}
