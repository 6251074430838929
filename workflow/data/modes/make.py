"""Make the modes of a paraboloid of 1.2 m with CalculiX 2.20 (``apt install calculix-ccx``).

``python make.py`` writes and runs ``paraboloid.inp``: four layers of C3D20R (face, two of core,
face), clamped at its hub: 20 modes, then a pressure of 1 Pa on each element of two patches. The
surface `MIDDLE` is the middle of the core, the only one that is printed. Focal length 0.48 m, faces
of 0.3 mm, core of 12 mm, 1.56 kg/m².
"""

import subprocess
from pathlib import Path

import numpy as np

FOCAL_LENGTH, HUB, RIM = 0.48, 0.12, 0.6  # [m]
FACE, CORE = 0.3e-3, 12e-3  # [m]
LEVELS = np.array([-CORE / 2 - FACE, -CORE / 2, 0.0, CORE / 2, CORE / 2 + FACE])
RADIAL, ROUND, MODES = 5, 22, 20
# Rings and sectors of the elements of two patches; INNER_1 … are their parts
PATCHES = {"INNER": ((1, 2), (0, 3)), "OUTER": ((3, 4), (11, 14))}

# Half steps: even ones are corners. A 20-node element has no node with two odd indices.
K, J, I = np.meshgrid(np.arange(9), np.arange(2 * RADIAL + 1), np.arange(2 * ROUND), indexing="ij")
number = np.full(K.shape, 0)
exists = (K % 2) + (J % 2) + (I % 2) < 2
number[exists] = 1 + np.arange(exists.sum())
radius, angle = HUB + (RIM - HUB) * J / (2 * RADIAL), np.pi * I / ROUND
level = np.interp(K, 2 * np.arange(5), LEVELS)
slope = radius / (2 * FOCAL_LENGTH)
tilt = np.sqrt(1 + slope**2)
outward = radius - level * slope / tilt  # along the normal of z = r²/(4F)
position = np.stack(
    [
        outward * np.cos(angle),
        outward * np.sin(angle),
        radius**2 / (4 * FOCAL_LENGTH) + level / tilt,
    ],
    axis=-1,
)

CORNERS = [(0, 0, 0), (0, 2, 0), (0, 2, 2), (0, 0, 2), (2, 0, 0), (2, 2, 0), (2, 2, 2), (2, 0, 2)]
EDGES = [
    (0, 1),
    (1, 2),
    (2, 3),
    (3, 0),
    (4, 5),
    (5, 6),
    (6, 7),
    (7, 4),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
]
OFFSETS = np.array(CORNERS + [np.add(CORNERS[a], CORNERS[b]) // 2 for a, b in EDGES])


def rows(numbers, count=10):
    """Return numbers as lines of a set."""
    numbers = list(map(str, numbers))
    return [",".join(numbers[k : k + count]) for k in range(0, len(numbers), count)]


lines = ["*NODE, NSET=ALL"]
lines += [
    f"{n},{x:.7g},{y:.7g},{z:.7g}"
    for n, (x, y, z) in zip(number[exists], position[exists], strict=True)
]
members = {"FACES": [], "CORE": [], "MIDDLES": []}
lines += ["*ELEMENT, TYPE=C3D20R, ELSET=ALL"]
element = 0
for layer in range(4):
    for ring in range(RADIAL):
        for sector in range(ROUND):
            element += 1
            k, j, i = (2 * np.array([layer, ring, sector]) + OFFSETS).T
            nodes = number[k, j, i % (2 * ROUND)].tolist()
            lines += [
                ",".join(map(str, [element, *nodes[:10]])) + ",",
                ",".join(map(str, nodes[10:])),
            ]
            members["CORE" if layer in (1, 2) else "FACES"].append(element)
            if layer == 2:
                members["MIDDLES"].append(element)
                for name, ((inner, outer), (first, last)) in PATCHES.items():
                    if inner <= ring <= outer and first <= sector < last:
                        part = 1 + 3 * (ring - inner) + sector - first
                        members.setdefault(name, []).append(element)
                        members.setdefault(f"{name}_{part}", []).append(element)
for name, elements in members.items():
    lines += [f"*ELSET, ELSET={name}", *rows(elements)]
lines += ["*SURFACE, NAME=MIDDLE, TYPE=ELEMENT", "MIDDLES, S1"]
lines += ["*NSET, NSET=HUB", *rows(number[:, 0][exists[:, 0]])]
lines += ["*NSET, NSET=PRINTED", *rows(number[4][exists[4]])]
lines += [
    "*MATERIAL, NAME=FACE", "*ELASTIC", "50e9, 0.3", "*DENSITY", "1600",
    "*MATERIAL, NAME=CORE", "*ELASTIC, TYPE=ENGINEERING CONSTANTS",
    "240e6, 240e6, 240e6, 0, 0, 0, 120e6, 120e6", "120e6", "*DENSITY", "50",
    "*SOLID SECTION, ELSET=FACES, MATERIAL=FACE", "*SOLID SECTION, ELSET=CORE, MATERIAL=CORE",
    "*BOUNDARY", "HUB, 1, 3",
    "*STEP", "*FREQUENCY", f"{MODES}", *(output := ["*NODE FILE, NSET=PRINTED", "U"]), "*END STEP",
]  # fmt: skip
for name in PATCHES:  # face 1 of the upper core: upward
    for part in range(1, 7):
        lines += [
            "*STEP",
            "*STATIC",
            "*DLOAD, OP=NEW",
            f"{name}_{part}, P1, 1",
            *output,
            "*END STEP",
        ]
folder = Path(__file__).parent
(folder / "paraboloid.inp").write_text("\n".join([*lines, ""]))
subprocess.run(["ccx", "paraboloid"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
for name in ("spooles.out", *(f"paraboloid.{suffix}" for suffix in ("12d", "cvg", "sta", "dat"))):
    (folder / name).unlink(missing_ok=True)
