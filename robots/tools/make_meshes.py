#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the convex meshes of robots/, from anywhere; the output is committed. With --check it writes nothing
and names the files that are not what it would write.

Every mesh is a list of convex parts, one OBJ object each, in the frame of its link or object [m]. The
parts are approximations of ours; the figures they are built from, and where those were published, stand
in the README beside each output. Output depends on nothing but this file.
"""

import math
import pathlib
import sys

ROBOTS = pathlib.Path(__file__).resolve().parent.parent
OTHERS = {"x": ("y", "z"), "y": ("x", "z"), "z": ("x", "y")}
MAX_VERTICES = 32


# --- points -------------------------------------------------------------------------------------------


def place(axis, at, points):
    """Points (u, v) of the plane `axis` = at; u and v are the other two axes in x, y, z order."""
    u, v = OTHERS[axis]
    return [tuple({axis: at, u: p[0], v: p[1]}[k] for k in "xyz") for p in points]


def ring(axis, at, u, v, cut=None):
    """Rectangle u x v (pairs of bounds) with its corners cut off, by one length or by four (at low u and v, then
    on towards high u); by default a regular octagon's cut."""
    if cut is None:
        cut = (1 - math.tan(math.pi / 8)) * min(u[1] - u[0], v[1] - v[0]) / 2
    a, b, c, d = cut if isinstance(cut, tuple) else (cut,) * 4
    return place(
        axis,
        at,
        [
            (u[0] + a, v[0]), (u[1] - b, v[0]), (u[1], v[0] + b), (u[1], v[1] - c),
            (u[1] - c, v[1]), (u[0] + d, v[1]), (u[0], v[1] - d), (u[0], v[0] + a),
        ],
    )  # fmt: skip


def disc(axis, at, radius, centre=(0, 0), n=8):
    """Regular n-gon round the circle, one side facing +u."""
    r = radius / math.cos(math.pi / n)
    angles = [2 * math.pi * (i + 0.5) / n for i in range(n)]
    return place(axis, at, [(centre[0] + r * math.cos(a), centre[1] + r * math.sin(a)) for a in angles])


def box(x, y, z):
    return [(a, b, c) for a in x for b in y for c in z]


def chamfered(x, y, z, cut):
    """Box with every edge and corner cut: 24 points."""
    bounds = (x, y, z)
    points = []
    for corner in box((0, 1), (0, 1), (0, 1)):
        for keep in range(3):
            points.append(
                tuple(
                    bounds[k][s] if k == keep else bounds[k][s] + (cut if s == 0 else -cut)
                    for k, s in enumerate(corner)
                )
            )
    return points


def prism(axis, bounds, points):
    """Polygon `points` (u, v) between two values of `axis`."""
    return place(axis, bounds[0], points) + place(axis, bounds[1], points)


def beam(a, b, half_x, half_n):
    """Bar of rectangular section from a to b in a plane x = const: half widths in x and across."""
    dy, dz = b[1] - a[1], b[2] - a[2]
    length = math.hypot(dy, dz)
    ny, nz = -dz / length * half_n, dy / length * half_n
    return [
        (p[0] + sx * half_x, p[1] + sn * ny, p[2] + sn * nz) for p in (a, b) for sx in (-1, 1) for sn in (-1, 1)
    ]


def mirrored(parts):
    return {name: [(x, -y, z) for x, y, z in points] for name, points in parts.items()}


# --- convex hulls -------------------------------------------------------------------------------------


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def outline(points, indices, normal):
    """The corners of a planar face, counter-clockwise seen from outside, without points on its edges."""
    start = points[indices[0]]
    e1 = max((sub(points[i], start) for i in indices), key=lambda e: dot(e, e))
    scale = math.sqrt(dot(e1, e1))
    e1 = tuple(c / scale for c in e1)
    e2 = cross(normal, e1)
    flat = sorted((dot(points[i], e1), dot(points[i], e2), i) for i in indices)

    def half(items):
        chain = []
        for p in items:
            while len(chain) > 1:
                a, b = chain[-2], chain[-1]
                turn = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
                if turn > 1e-10:
                    break
                chain.pop()
            chain.append(p)
        return chain[:-1]

    corners = [p[2] for p in half(flat) + half(flat[::-1])]
    first = corners.index(min(corners))
    return corners[first:] + corners[:first]


def hull(points):
    """(vertices, triangles) of the convex hull, by trying every plane through three points."""
    points = sorted({tuple(round(c, 9) + 0.0 for c in p) for p in points})
    n = len(points)
    faces = {}
    for i in range(n):
        for j in range(i + 1, n):
            for k in range(j + 1, n):
                normal = cross(sub(points[j], points[i]), sub(points[k], points[i]))
                length = math.sqrt(dot(normal, normal))
                if length < 1e-9:
                    continue
                normal = tuple(c / length for c in normal)
                on, above, below = [], False, False
                for m in range(n):
                    height = dot(normal, sub(points[m], points[i]))
                    if height > 1e-8:
                        above = True
                    elif height < -1e-8:
                        below = True
                    else:
                        on.append(m)
                    if above and below:
                        break
                if above and below:
                    continue
                if above:
                    normal = tuple(-c for c in normal)
                faces.setdefault(tuple(on), normal)
    triangles = []
    for on in sorted(faces):
        corners = outline(points, list(on), faces[on])
        triangles += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    used = sorted({i for t in triangles for i in t})
    index = {old: new for new, old in enumerate(used)}
    return [points[i] for i in used], [tuple(index[i] for i in t) for t in triangles]


def text_of(name, parts):
    lines = ["# SPDX-License-Identifier: Apache-2.0", "# Made by robots/tools/make_meshes.py; metres."]
    base = 1
    for part, points in parts.items():
        vertices, triangles = hull(points)
        if len(vertices) > MAX_VERTICES:
            raise SystemExit(f"{name}: part {part} has {len(vertices)} vertices")
        lines.append(f"o {part}")
        lines += ["v " + " ".join(f"{c:.9f}".rstrip("0").rstrip(".") for c in v) for v in vertices]
        lines += ["f " + " ".join(str(base + i) for i in t) for t in triangles]
        base += len(vertices)
    return "\n".join(lines) + "\n"


# --- Schunk LWA 4D and SDH ----------------------------------------------------------------------------


def drum(axis, radius, start, end, bevel=0.0, n=8):
    """Cylinder with bevelled ends: `bevel` inwards and along the axis."""
    if not bevel:
        return disc(axis, start, radius, n=n) + disc(axis, end, radius, n=n)
    s = math.copysign(bevel, end - start)
    return (
        disc(axis, start, radius - bevel, n=n)
        + disc(axis, start + s, radius, n=n)
        + disc(axis, end - s, radius, n=n)
        + disc(axis, end, radius - bevel, n=n)
    )


def around(axis, centre, *profile):
    """Body of revolution about a line along `axis`: (position, radius), from one end to the other."""
    return [p for at, radius in profile for p in disc(axis, at, radius, centre)]


def turned(axis, *profile):
    return around(axis, (0, 0), *profile)


def crichton():
    # A link of odd number: a drum, and beside the next joint a plate that carries it, joined by a neck. One of
    # even number: a drum across, and a neck to the collar in which the next drum turns.
    yield "L1", {
        "drum": turned("z", (0.087, 0.052), (0.073, 0.066), (-0.050, 0.066), (-0.0765, 0.062)),
        "stub": turned("z", (-0.0765, 0.046), (-0.1005, 0.046)),
        "neck": prism(
            "x",
            (-0.045, 0.045),
            [(0.0, -0.0765), (-0.060, -0.0765), (-0.0890, -0.104), (-0.0890, -0.150)]
            + [(-0.0635, -0.150), (-0.052, -0.132), (0.0, -0.1015)],
        ),
        "plate": around("y", (0, -0.18), (-0.098, 0.0622), (-0.0640, 0.0622)),
    }
    yield "L2", {
        "drum": turned("z", (0.090, 0.0605), (0.084, 0.066), (-0.071, 0.066), (-0.086, 0.044)),
        "neck": prism(
            "x",
            (-0.038, 0.038),
            [(0.0, 0.088), (0.085, 0.088), (0.1065, 0.052), (0.1065, -0.038), (0.077, -0.038), (0.056, -0.067)]
            + [(0.0, -0.067)],
        ),
        "collar": turned("y", (0.1020, 0.051), (0.1175, 0.051)),
    }
    yield "L3", {
        "drum": turned("z", (-0.0905, 0.042), (-0.1045, 0.056), (-0.208, 0.056), (-0.236, 0.051)),
        "stub": turned("z", (-0.236, 0.0386), (-0.2560, 0.0386)),
        "neck": prism(
            "x",
            (-0.038, 0.038),
            [(0.0, -0.236), (-0.050, -0.236), (-0.0785, -0.258), (-0.0785, -0.304)]
            + [(-0.0535, -0.304), (-0.044, -0.284), (0.0, -0.2565)],
        ),
        "plate": around("y", (0, -0.328), (-0.086, 0.0515), (-0.0530, 0.0515)),
    }
    yield "L4", {
        "drum": turned("z", (0.0790, 0.0515), (0.0745, 0.056), (-0.060, 0.056), (-0.0780, 0.036)),
        "neck": prism(
            "x",
            (-0.031, 0.031),
            [(0.0, 0.0775), (0.076, 0.0775), (0.0975, 0.042), (0.0975, -0.031), (0.068, -0.031), (0.052, -0.057)]
            + [(0.0, -0.057)],
        ),
        "collar": turned("y", (0.0930, 0.0415), (0.1065, 0.0415)),
    }
    yield "L5", {
        "drum": turned("z", (-0.081, 0.030), (-0.096, 0.045), (-0.237, 0.045), (-0.2660, 0.0370)),
        "neck": prism(
            "x",
            (-0.0275, 0.0275),
            [(0.0, -0.2175), (-0.046, -0.2175), (-0.0925, -0.276), (-0.0925, -0.302)]
            + [(-0.0525, -0.302), (-0.0525, -0.286), (-0.038, -0.266), (0.0, -0.2660)],
        ),
        "plate": around("y", (0, -0.323), (-0.0935, 0.0436), (-0.0520, 0.0436)),
    }
    yield "L6", {
        # A ball, cut flat where the flange sits.
        "ball": disc("y", 0.0560, 0.022)
        + disc("y", 0.0380, 0.044)
        + disc("y", 0.0, 0.0570)
        + disc("y", -0.0395, 0.042),
        "stub": drum("z", 0.0385, -0.0755, -0.02, 0.006),
    }
    yield "L7", {"flange": disc("z", 0.035, 0.041, n=16) + disc("z", -0.009, 0.041, n=16)}

    # SDH. The palm is flat towards the two fingers (+x) and narrows towards the thumb (-x).
    def palm_ring(z, x0, x1, y, wide, slim):
        return place(
            "z",
            z,
            [(x1, wide), (x1 + wide - y, y), (x0 + y - slim, y), (x0, slim)]
            + [(x0, -slim), (x0 + y - slim, -y), (x1 + wide - y, -y), (x1, -wide)],
        )

    yield "sdh_palm", {
        "palm": disc("z", -0.0025, 0.034)
        + palm_ring(0.008, -0.0570, 0.0465, 0.060, 0.042, 0.018)
        + palm_ring(0.038, -0.0665, 0.0465, 0.061, 0.0465, 0.013)
        + palm_ring(0.0735, -0.0665, 0.0465, 0.061, 0.0465, 0.013)
    }
    yield "sdh_knuckle", {
        "foot": disc("z", -0.0005, 0.0222) + disc("z", 0.0035, 0.0222),
        "fork": ring("y", -0.0205, (-0.0135, 0.0135), (0.002, 0.0305))
        + ring("y", 0.0262, (-0.0135, 0.0135), (0.002, 0.0305)),
    }
    # Both ends are round about the joints' axes (along y): the proximal one must turn over the palm.
    yield "sdh_finger", {
        "phalanx": [
            (x, y * (0.0078 if abs(x) > 0.01 and inner else 0.0135), z)
            for x, z, inner in (
                (-0.0056, -0.0135, False), (0.0056, -0.0135, False),
                (-0.0130, -0.0056, True), (0.0135, -0.0056, True),
                (-0.0130, 0.0920, True), (0.0150, 0.0800, True),
                (-0.0056, 0.1000, False), (0.0056, 0.1000, False),
            )
            for y in (-1, 1)
        ]
        + [(x, y, z) for x in (-0.0068, 0.0088) for y in (-0.0135, 0.0135) for z in (0.0, 0.085)]
    }  # fmt: skip
    yield "sdh_tip", {
        "fork": ring("y", 0.0075, (-0.0135, 0.0135), (-0.0140, 0.0200))
        + ring("y", 0.0172, (-0.0135, 0.0135), (-0.0140, 0.0200)),
        "tip": ring("z", 0.0110, (-0.0125, 0.0152), (-0.0135, 0.0135), 0.007)
        + ring("z", 0.0430, (-0.0100, 0.0152), (-0.0135, 0.0135), 0.007)
        + ring("z", 0.0600, (-0.0090, 0.0122), (-0.0135, 0.0135), 0.007)
        + ring("z", 0.0685, (-0.0075, 0.0085), (-0.0110, 0.0110), 0.006),
    }


# --- DRC-Hubo -----------------------------------------------------------------------------------------


def hubo_middle():
    yield "TSY", {
        "pelvis": ring("z", 0.015, (-0.1145, 0.0705), (-0.1305, 0.1305))
        + ring("z", -0.066, (-0.1145, 0.0705), (-0.127, 0.127))
        + ring("z", -0.0855, (-0.108, 0.063), (-0.1155, 0.1155))
    }
    yield "Torso", {
        "waist": ring("z", -0.0005, (-0.045, 0.045), (-0.033, 0.035), 0.016)
        + ring("z", 0.032, (-0.043, 0.043), (-0.029, 0.030), 0.010),
        "chest": ring("z", 0.030, (-0.134, 0.064), (-0.127, 0.127), 0.007)
        + ring("z", 0.062, (-0.150, 0.115), (-0.1315, 0.1315), 0.008)
        + ring("z", 0.160, (-0.151, 0.115), (-0.1415, 0.1430), 0.019)
        + ring("z", 0.233, (-0.151, 0.115), (-0.1415, 0.1430), 0.019),
        "shoulders": ring("z", 0.233, (-0.151, 0.115), (-0.1415, 0.1430), 0.019)
        + ring("z", 0.2525, (-0.151, 0.096), (-0.1405, 0.1420), (0.018, 0.036, 0.037, 0.018))
        + ring("z", 0.2625, (-0.149, 0.075), (-0.132, 0.133), (0.011, 0.023, 0.024, 0.011)),
    }
    yield "NKY", {
        "neck": ring("z", 0.0, (-0.048, 0.014), (-0.019, 0.019), 0.005)
        + ring("z", 0.0115, (-0.051, 0.015), (-0.0395, 0.0355), (0.022, 0.004, 0.001, 0.018))
        + ring("z", 0.056, (-0.051, 0.015), (-0.0390, 0.0355), (0.020, 0.003, 0.001, 0.017))
        + ring("z", 0.0705, (-0.051, 0.015), (-0.021, 0.021), 0.003)
    }
    # A fork that nods, with a bar across its top.
    yield "NK1", {
        "bar": ring("z", -0.0785, (-0.026, 0.024), (-0.191, -0.150), 0.004)
        + ring("z", -0.060, (-0.029, 0.029), (-0.191, -0.150), (0.007, 0.009, 0.002, 0.002))
        + ring("z", 0.060, (-0.029, 0.029), (-0.191, -0.150), (0.007, 0.009, 0.002, 0.002))
        + ring("z", 0.0785, (-0.026, 0.024), (-0.191, -0.150), 0.004),
        "cheek_1": ring("y", -0.150, (-0.020, 0.020), (-0.0605, -0.018), 0.002)
        + ring("y", -0.108, (-0.020, 0.020), (-0.0860, -0.018), 0.003)
        + ring("y", 0.0145, (-0.020, 0.020), (-0.0855, -0.034), 0.002),
        "cheek_2": ring("y", -0.150, (-0.020, 0.020), (0.018, 0.0605), 0.002)
        + ring("y", -0.108, (-0.020, 0.020), (0.018, 0.0860), 0.003)
        + ring("y", 0.0145, (-0.020, 0.020), (0.028, 0.0860), 0.002),
    }
    yield "NK2", {
        "sensor": ring("z", -0.0555, (-0.020, 0.039), (-0.029, 0.029), (0.001, 0.014, 0.014, 0.001))
        + ring("z", -0.020, (-0.020, 0.0395), (-0.0355, 0.038), (0.005, 0.012, 0.013, 0.006))
        + ring("z", 0.0255, (-0.020, 0.040), (-0.0355, 0.0395), (0.005, 0.006, 0.009, 0.007))
    }


def hubo_left():
    """Links of the left side, frames of the robot's own joints; the right side is their mirror image."""
    yield "SP", {
        "hub": turned("y", (0.0, 0.0425), (0.018, 0.0425)),
        "shoulder": ring("y", 0.018, (-0.049, 0.057), (-0.0275, 0.0275), 0.003)
        + ring("y", 0.053, (-0.059, 0.057), (-0.031, 0.031), (0.012, 0.003, 0.003, 0.012))
        + ring("y", 0.095, (-0.059, 0.057), (-0.0425, 0.0425), (0.010, 0.003, 0.003, 0.010))
        + ring("y", 0.1405, (-0.059, 0.057), (-0.032, 0.032), (0.012, 0.004, 0.004, 0.012)),
    }
    yield "SR", {
        "yoke": ring("z", 0.031, (-0.078, 0.005), (-0.014, 0.014), 0.004)
        + ring("z", 0.012, (-0.084, 0.012), (-0.0315, 0.0315), 0.012)
        + ring("z", -0.026, (-0.084, 0.012), (-0.0415, 0.0335), (0.030, 0.018, 0.012, 0.024))
        + ring("z", -0.091, (-0.069, 0.002), (-0.0415, 0.0335), (0.028, 0.025, 0.017, 0.020))
    }
    yield "SY", {
        "upper_arm": turned("z", (0.0, 0.029), (-0.050, 0.034), (-0.0905, 0.034)),
        "elbow_drive": ring("z", -0.0905, (-0.034, 0.034), (-0.035, 0.0345), 0.005)
        + ring("z", -0.215, (-0.0325, 0.0360), (-0.0485, 0.038), (0.014, 0.013, 0.004, 0.004))
        + ring("z", -0.262, (-0.0245, 0.0585), (-0.0485, 0.038), (0.011, 0.011, 0.001, 0.001))
        + ring("z", -0.302, (0.004, 0.053), (-0.0475, 0.038), (0.011, 0.011, 0.001, 0.001)),
    }
    yield "EP", {
        "elbow": prism(
            "y",
            (-0.0335, 0.0335),
            [(-0.012, 0.0265), (0.012, 0.0265), (0.026, 0.012), (0.026, -0.020)]
            + [(-0.001, -0.0985), (-0.058, -0.0985), (-0.064, -0.092), (-0.064, -0.034), (-0.044, 0.0)],
        )
    }
    yield "WY", {
        "sleeve": turned("z", (0.0, 0.0215), (-0.040, 0.027), (-0.090, 0.027)),
        "bridge": ring("z", -0.018, (-0.021, 0.022), (0.0, 0.030), 0.004)
        + ring("z", -0.043, (-0.027, 0.027), (0.0, 0.050), 0.003)
        + ring("z", -0.096, (-0.027, 0.027), (0.0, 0.050), 0.003),
        # One-sided: it carries the wrist from its +y side and leaves the hand's sweep free.
        "wrist_drive": ring("z", -0.0425, (-0.029, 0.029), (0.036, 0.1095), 0.003)
        + ring("z", -0.200, (-0.029, 0.029), (0.0440, 0.1245), (0.005, 0.005, 0.013, 0.013))
        + ring("z", -0.272, (-0.029, 0.029), (0.0475, 0.1245), (0.003, 0.003, 0.012, 0.012))
        + ring("z", -0.2925, (-0.023, 0.023), (0.0490, 0.1225), (0.003, 0.003, 0.014, 0.014)),
    }
    yield "WP", {
        "wrist": ring("z", -0.031, (-0.031, 0.031), (-0.031, 0.085), (0.002, 0.002, 0.022, 0.014))
        + ring("z", 0.004, (-0.031, 0.031), (-0.031, 0.085), (0.002, 0.002, 0.022, 0.014))
        + ring("z", 0.036, (-0.031, 0.031), (-0.031, 0.077), (0.002, 0.002, 0.028, 0.024)),
        "motor": disc("z", 0.020, 0.0135) + disc("z", 0.145, 0.0110),
    }
    yield "WR", {
        "palm": disc("z", 0.0, 0.021)
        + ring("z", -0.040, (-0.036, 0.038), (-0.045, 0.043), 0.014)
        + ring("z", -0.0800, (-0.036, 0.038), (-0.045, 0.043), 0.014)
        + ring("z", -0.0905, (-0.030, 0.032), (-0.039, 0.037), 0.012)
    }
    yield "HY", {"hip": chamfered((-0.0505, 0.0825), (-0.045, 0.045), (-0.186, 0.0), 0.018)}
    yield "HR", {
        "hip": ring("z", -0.0725, (-0.036, 0.036), (-0.049, 0.049), 0.001)
        + ring("z", -0.027, (-0.0505, 0.0575), (-0.0590, 0.049), (0.026, 0.013, 0.003, 0.015))
        + ring("z", 0.026, (-0.0505, 0.0575), (-0.0590, 0.048), (0.030, 0.013, 0.001, 0.016))
        + ring("z", 0.0470, (-0.017, 0.0575), (-0.036, 0.0465), (0.010, 0.006, 0.012, 0.001)),
        "flange": turned("x", (0.020, 0.048), (0.0575, 0.046)),
    }
    yield "HP", {
        "thigh": ring("z", -0.115, (-0.0385, 0.0845), (-0.0715, 0.056), (0.017, 0.017, 0.003, 0.003))
        + ring("z", -0.150, (-0.035, 0.0840), (-0.0710, 0.056), (0.017, 0.017, 0.003, 0.003))
        + ring("z", -0.270, (-0.020, 0.0740), (-0.0590, 0.056), (0.008, 0.006, 0.002, 0.005))
        + ring("z", -0.333, (-0.020, 0.0575), (-0.0560, 0.056), (0.004, 0.003, 0.002, 0.001)),
        "hip": ring("z", 0.0475, (-0.0290, 0.0290), (-0.0710, 0.0685), (0.018, 0.018, 0.002, 0.002))
        + ring("z", 0.020, (-0.0450, 0.0545), (-0.0710, 0.0685), (0.022, 0.020, 0.002, 0.002))
        + ring("z", -0.010, (-0.0475, 0.0660), (-0.0710, 0.0685), (0.022, 0.018, 0.010, 0.002))
        + ring("z", -0.130, (-0.0385, 0.0845), (-0.0710, 0.056), (0.017, 0.017, 0.003, 0.003)),
        "knee": around("y", (0, -0.3299), (-0.056, 0.036), (-0.044, 0.0475), (0.056, 0.0475)),
    }
    yield "KP", {
        "lug": around("y", (0, 0), (-0.055, 0.028), (-0.040, 0.0372), (0.0175, 0.0372)),
        "shin": ring("z", -0.007, (-0.034, 0.050), (-0.0560, 0.056), (0.020, 0.011, 0.008, 0.036))
        + ring("z", -0.072, (-0.030, 0.065), (-0.0590, 0.0575), (0.012, 0.005, 0.004, 0.011))
        + ring("z", -0.262, (-0.017, 0.065), (-0.068, 0.066), (0.012, 0.014, 0.012, 0.004))
        + ring("z", -0.345, (-0.020, 0.0455), (-0.068, 0.068), (0.014, 0.014, 0.006, 0.002)),
        "ankle": around("y", (0, -0.330), (-0.068, 0.025), (-0.051, 0.0425), (0.068, 0.0425)),
    }
    yield "AP", {
        "cross": ring("z", -0.0425, (-0.034, 0.071), (-0.032, 0.063), (0.015, 0.006, 0.034, 0.006))
        + ring("z", -0.025, (-0.0505, 0.0750), (-0.059, 0.063), (0.029, 0.026, 0.030, 0.011))
        + ring("z", 0.025, (-0.0505, 0.0750), (-0.059, 0.063), (0.029, 0.026, 0.030, 0.011))
        + ring("z", 0.0425, (-0.040, 0.071), (-0.032, 0.063), (0.018, 0.006, 0.034, 0.012)),
        "horn": ring("z", 0.020, (-0.0195, 0.0215), (-0.049, 0.0495), 0.003)
        + ring("z", 0.0705, (-0.0165, 0.0170), (-0.049, 0.0495), 0.003),
    }
    yield "AR", {
        "foot": ring("z", -0.137, (-0.079, 0.141), (-0.069, 0.079), 0.0165)
        + ring("z", -0.1195, (-0.079, 0.141), (-0.069, 0.079), 0.0165),
        "stem": turned("z", (-0.1195, 0.040), (-0.100, 0.0405)),
        "ankle": ring("z", -0.101, (-0.043, 0.0825), (-0.032, 0.032), (0.011, 0.010, 0.016, 0.011))
        + ring("z", -0.036, (-0.0515, 0.0815), (-0.0335, 0.0335), (0.005, 0.008, 0.009, 0.005))
        + ring("z", 0.004, (-0.0500, 0.0800), (-0.0375, 0.0375), (0.002, 0.011, 0.010, 0.002))
        + ring("z", 0.0370, (-0.0480, 0.0770), (-0.0250, 0.0250), (0.001, 0.011, 0.011, 0.001)),
    }


def hubo_left_finger():
    yield "1", {"phalanx": chamfered((-0.013, 0.013), (-0.021, -0.001), (-0.051, 0.011), 0.005)}
    yield "2", {"phalanx": chamfered((-0.011, 0.011), (-0.010, 0.010), (-0.0395, 0.0115), 0.005)}
    yield "3", {"phalanx": chamfered((-0.009, 0.009), (-0.010, 0.010), (-0.034, 0.008), 0.004)}


# --- a seated person ----------------------------------------------------------------------------------


def person():
    """Links without sides, in the frames of the robot's joints; z of a limb's frame points up it when it hangs."""

    def oval(at, half_x, half_y, x=0.0, y=0.0):
        return ring("z", at, (x - half_x, x + half_x), (y - half_y, y + half_y))

    legs = {}
    for i, s in enumerate((1, -1)):
        # Thighs level and a little apart, shins upright.
        legs[f"thigh_{i + 1}"] = ring("x", -0.02, (s * 0.0875 - 0.075, s * 0.0875 + 0.075), (-0.080, 0.075)) + ring(
            "x", 0.43, (s * 0.115 - 0.058, s * 0.115 + 0.058), (-0.062, 0.055)
        )
        legs[f"shin_{i + 1}"] = (
            oval(0.0, 0.058, 0.055, 0.415, s * 0.115)
            + oval(-0.13, 0.058, 0.055, 0.405, s * 0.115)
            + oval(-0.416, 0.042, 0.040, 0.415, s * 0.115)
        )
        legs[f"foot_{i + 1}"] = ring("z", -0.482, (0.355, 0.605), (s * 0.115 - 0.048, s * 0.115 + 0.048), 0.025) + ring(
            "z", -0.416, (0.365, 0.475), (s * 0.115 - 0.040, s * 0.115 + 0.040), 0.020
        )
    yield "Body", {"pelvis": oval(-0.085, 0.100, 0.160) + oval(0.0, 0.115, 0.175) + oval(0.12, 0.100, 0.150)} | legs
    yield "Torso", {
        "belly": oval(0.10, 0.105, 0.150) + oval(0.24, 0.105, 0.140),
        "chest": oval(0.22, 0.105, 0.135) + oval(0.36, 0.115, 0.130) + oval(0.46, 0.090, 0.122, -0.01),
        "collar": oval(0.44, 0.090, 0.122, -0.01) + oval(0.50, 0.060, 0.115, -0.01) + oval(0.54, 0.05, 0.06, -0.01),
        "neck": oval(0.50, 0.055, 0.055) + oval(0.60, 0.055, 0.055),
    }
    # Its frame is where the neck ends, at the chin's height.
    yield "Head", {
        "head": oval(-0.01, 0.060, 0.050, 0.03)
        + oval(0.07, 0.098, 0.076, 0.01)
        + oval(0.15, 0.098, 0.076, 0.0)
        + oval(0.22, 0.050, 0.040, -0.01)
    }
    yield "UpperArm", {
        "arm": turned("z", (-0.030, 0.038), (-0.12, 0.045), (-0.25, 0.040), (-0.300, 0.036)),
        "elbow": around("y", (0, -0.314), (-0.038, 0.032), (0.038, 0.032)),
    }
    yield "Forearm", {"arm": turned("z", (-0.02, 0.037), (-0.07, 0.042), (-0.16, 0.034), (-0.228, 0.025))}
    yield "Wrist", {"wrist": turned("z", (0.016, 0.021), (0.0, 0.022), (-0.010, 0.018))}


def person_left():
    yield "Shoulder", {
        "ball": disc("y", -0.040, 0.030) + disc("y", -0.022, 0.048) + disc("y", 0.018, 0.050) + disc("y", 0.044, 0.028)
    }
    # The palm looks to -y, the thumb's side is +x.
    yield "Palm", {
        "palm": ring("z", -0.006, (-0.018, 0.018), (-0.011, 0.011), 0.005)
        + ring("z", -0.040, (-0.036, 0.038), (-0.015, 0.014), 0.007)
        + ring("z", -0.098, (-0.040, 0.040), (-0.015, 0.011), 0.007)
        + ring("z", -0.110, (-0.038, 0.038), (-0.010, 0.006), 0.004)
    }
    yield "Finger1", {"phalanx": turned("z", (0.007, 0.0055), (0.0, 0.0090), (-0.043, 0.0080), (-0.049, 0.0055))}
    yield "Finger2", {"phalanx": turned("z", (0.005, 0.0055), (0.0, 0.0080), (-0.028, 0.0072), (-0.034, 0.0045))}
    yield "Thumb1", {"phalanx": turned("y", (0.008, 0.0065), (0.0, 0.0110), (-0.044, 0.0095), (-0.051, 0.0065))}
    yield "Thumb2", {"phalanx": turned("y", (0.006, 0.0065), (0.0, 0.0095), (-0.024, 0.0088), (-0.031, 0.0055))}


# --- objects ------------------------------------------------------------------------------------------


def nine_sided_cup():
    """Upright along z: open rim at z = +0.0755, closed base below; nine wall panels and the base."""
    n, half, rim, base, wall = 9, 0.0755, 0.046, 0.034, 0.003
    floor = -half + wall

    def outer(z):
        return base + (rim - base) * (z + half) / (2 * half)

    def corner(i, z, inset):
        # The wall is `wall` thick measured across a panel, in the horizontal.
        r = outer(z) - (inset / math.cos(math.pi / n))
        a = 2 * math.pi * i / n
        return (r * math.cos(a), r * math.sin(a), z)

    parts = {"base": [corner(i, z, 0) for i in range(n) for z in (-half, floor)]}
    for i in range(n):
        parts[f"panel_{i + 1}"] = [
            corner(k, z, inset) for k in (i, i + 1) for z in (floor, half) for inset in (0, wall)
        ]
    return parts


def table():
    """Origin: the corner of lowest x and y, on the floor."""
    x, y, top, bar = 0.6096, 1.8288, 0.6731, 0.0254
    under, post, beam_z, height = top - bar, (0.2921, 0.3175), 1.8923, 2.1971

    def strut(edge, way, z, up):
        """A bar at 45 degrees in the corner of an upright `edge` and a level z, its section in their plane."""
        return [(edge, z + up * n * bar) for n in (4, 3)] + [(edge + way * n * bar, z) for n in (3, 4)]

    parts = {"top": box((0, x), (0, y), (under, top))}
    for i, a in enumerate((bar, x - 3 * bar)):
        for j, b in enumerate((bar, y - 3 * bar)):
            parts[f"leg_{1 + i + 2 * j}"] = box((a, a + 2 * bar), (b, b + 2 * bar), (0, under))
    # Two posts with struts to the table on three sides; between them a frame with the sign.
    for i, (outside, inside, way) in enumerate(((0, bar, 1), (y, y - bar, -1))):
        parts[f"post_{i + 1}"] = box(post, (outside, inside), (under, height))
        for j, (edge, out) in enumerate(((post[0], -1), (post[1], 1))):
            parts[f"strut_{i + 1}_{j + 1}"] = prism("y", (outside, inside), strut(edge, out, top, 1))
        parts[f"strut_{i + 1}_3"] = prism("x", post, strut(inside, way, top, 1))
        parts[f"strut_{i + 1}_4"] = prism("x", post, strut(inside, way, beam_z, -1))
    # The letters stand 6 mm out of the frame, here it is 3 mm thicker all over.
    parts["sign"] = box((post[0], 0.3205), (bar, y - bar), (beam_z, height))
    return parts


def cart():
    """Origin: on the floor, as in the scenes; it covers x -0.012 .. 0.998, y 0.017 .. 0.567."""
    parts = {}
    for i, z in enumerate((0.190, 0.510, 0.817)):
        # 3 mm longer and wider on each side than the shelf, for the brackets at its corners.
        parts[f"shelf_{i + 1}"] = box((0.031, 0.955), (0.027, 0.556), (z - 0.032, z))
    # At each end two wheels and a U, which leans out above the upper shelf.
    ends = ((0.0415, (0.015, 0.081), 0.0485, 0.0372), (0.9445, (0.904, 0.971), 0.9373, 0.9486))
    for i, (wheel, fork, tube, top) in enumerate(ends):
        for j, y in enumerate((0.0435, 0.5405)):
            parts[f"wheel_{i + 1}_{j + 1}"] = around(
                "y", (wheel, 0.0535), (y - 0.0265, 0.0535), (y + 0.0265, 0.0535)
            ) + box(fork, (y - 0.0245, y + 0.0245), (0.130,))
            parts[f"handle_{i + 1}_post_{j + 1}"] = (
                disc("z", 0.130, 0.0125, (tube, y))
                + disc("z", 0.820, 0.0125, (tube, y))
                + disc("z", 0.945, 0.0125, (top, y))
            )
        across = (top - 0.013, top + 0.013)
        parts[f"handle_{i + 1}"] = (
            ring("y", 0.031, across, (0.934, 0.950), 0.005)
            + ring("y", 0.050, across, (0.937, 0.9634), 0.005)
            + ring("y", 0.534, across, (0.937, 0.9634), 0.005)
            + ring("y", 0.553, across, (0.934, 0.950), 0.005)
        )
    return parts


def milk_carton():
    """Upright along z, origin in the middle."""
    h, half, shoulder = 0.0435, 0.1195, 0.070
    return {
        "body": box((-h, h), (-h, h), (-half, shoulder)),
        "gable": box((-h, h), (-h, h), (shoulder,)) + box((-h, h), (-0.003, 0.003), (0.105, half)),
    }


def hammer():
    """Handle along z, head along y: face towards +y, claw towards -y."""
    return {
        "handle": ring("z", -0.170, (-0.011, 0.011), (-0.014, 0.014), 0.006)
        + ring("z", 0.135, (-0.011, 0.011), (-0.014, 0.014), 0.006),
        "head": chamfered((-0.013, 0.013), (-0.022, 0.026), (0.130, 0.160), 0.004),
        "face": disc("y", 0.026, 0.013, (0, 0.145))
        + disc("y", 0.036, 0.0148, (0, 0.145))
        + disc("y", 0.057, 0.0148, (0, 0.145)),
        "claw_root": ring("y", -0.022, (-0.013, 0.013), (0.134, 0.160), 0.004)
        + ring("y", -0.050, (-0.016, 0.016), (0.141, 0.158), 0.003),
        "claw": ring("y", -0.050, (-0.016, 0.016), (0.141, 0.158), 0.003)
        + ring("y", -0.075, (-0.016, 0.016), (0.132, 0.139), 0.002),
    }


def dog_plate():
    """Ring of twelve wall pieces and a floor; axis z, origin in the middle."""
    n, inner, outer, half = 12, 0.129, 0.149, 0.050

    def corner(i, r, z):
        a = 2 * math.pi * i / n
        return (r * math.cos(a), r * math.sin(a), z)

    parts = {"floor": [corner(i, inner, z) for i in range(n) for z in (-half, 0.0005)]}
    for i in range(n):
        parts[f"wall_{i + 1}"] = [
            corner(k, r, z) for k in (i, i + 1) for r in (inner, outer) for z in (-half, half)
        ]
    return parts


def stool():
    """Three steps rising towards +y; origin 0.475 above its feet."""
    left, right = (-0.200, -0.175), (0.171, 0.1965)
    parts = {}
    for i, (y, z) in enumerate(((-0.323, -0.213), (-0.201, 0.050), (-0.078, 0.312))):
        parts[f"step_{i + 1}"] = box((left[1], right[0]), (y, 0.151 if i == 2 else y + 0.143), (z - 0.038, z))
    for side, x in (("left", left), ("right", right)):
        parts[f"rail_{side}"] = prism("x", x, [(-0.394, -0.475), (-0.344, -0.475), (0.137, 0.556), (0.095, 0.575)])
        parts[f"leg_{side}"] = prism("x", x, [(0.180, -0.475), (0.218, -0.475), (0.074, 0.420), (0.045, 0.359)])
    parts["bar"] = [
        (x, y, z)
        for ends, edges in (
            ((left[0], right[1]), ((0.095, 0.575), (0.137, 0.556))),
            ((-0.168, 0.164), ((0.109, 0.605), (0.151, 0.586))),
        )
        for x in ends
        for y, z in edges
    ]
    parts["brace"] = box((left[1], right[0]), (0.159, 0.178), (-0.317, -0.297))
    return parts


def dog():
    """Decor: standing, nose towards -y; origin as in the scenes, 0.42 above its paws."""

    def slice_at(y, half, z, under=0.02, over=0.02):
        return ring("y", y, (-half, half), z, (under, under, over, over))

    parts = {
        "muzzle": slice_at(-0.266, 0.018, (0.056, 0.110), 0.008, 0.006)
        + slice_at(-0.236, 0.036, (0.039, 0.150))
        + slice_at(-0.186, 0.072, (0.038, 0.217), 0.038, 0.034),
        "head": slice_at(-0.186, 0.072, (0.038, 0.217), 0.038, 0.034)
        + slice_at(-0.150, 0.094, (0.032, 0.242), 0.045, 0.020)
        + slice_at(-0.108, 0.107, (0.032, 0.242), 0.045, 0.020)
        + slice_at(-0.080, 0.104, (0.032, 0.222), 0.045, 0.050),
        "chest": slice_at(-0.146, 0.090, (-0.062, 0.100), 0.080)
        + slice_at(-0.106, 0.106, (-0.121, 0.220), 0.078)
        + slice_at(-0.062, 0.104, (-0.210, 0.213), 0.022, 0.062)
        + slice_at(-0.018, 0.109, (-0.210, 0.160), 0.018, 0.080),
        "back": slice_at(-0.018, 0.109, (-0.210, 0.155), 0.018, 0.080)
        + slice_at(0.014, 0.107, (-0.205, 0.092), 0.030, 0.070)
        + slice_at(0.050, 0.090, (-0.161, 0.045), 0.035, 0.044)
        + slice_at(0.165, 0.072, (-0.139, 0.026), 0.052, 0.042),
        "loin": slice_at(0.160, 0.072, (-0.139, 0.026), 0.050, 0.042)
        + slice_at(0.196, 0.090, (-0.186, 0.026), 0.026, 0.055)
        + slice_at(0.270, 0.100, (-0.210, 0.014), 0.018, 0.056)
        + slice_at(0.350, 0.066, (-0.205, -0.008), 0.006, 0.036),
        "tail": slice_at(0.345, 0.034, (-0.098, 0.0), 0.024, 0.012)
        + slice_at(0.460, 0.030, (-0.078, 0.062), 0.022, 0.018)
        + slice_at(0.482, 0.028, (-0.062, 0.150), 0.022, 0.018)
        + slice_at(0.528, 0.014, (-0.016, 0.116), 0.010, 0.008),
    }
    for i, s in enumerate((-1, 1)):

        def side(a, b, s=s):
            return tuple(sorted((s * a, s * b)))

        parts[f"ear_{i + 1}"] = ring("z", 0.200, side(0.050, 0.104), (-0.150, -0.106), 0.006) + ring(
            "z", 0.277, side(0.076, 0.094), (-0.144, -0.122), 0.003
        )
        parts[f"fore_leg_{i + 1}"] = (
            ring("z", -0.420, side(0.031, 0.095), (-0.106, -0.012), 0.008)
            + ring("z", -0.355, side(0.031, 0.096), (-0.106, -0.008), 0.008)
            + ring("z", -0.310, side(0.031, 0.097), (-0.075, 0.014), 0.008)
            + ring("z", -0.190, side(0.030, 0.102), (-0.072, 0.018), 0.008)
        )
        parts[f"hind_leg_{i + 1}"] = (
            ring("z", -0.420, side(0.008, 0.079), (0.234, 0.345), 0.008)
            + ring("z", -0.345, side(0.008, 0.079), (0.234, 0.355), 0.008)
            + ring("z", -0.190, side(0.008, 0.095), (0.214, 0.355), 0.008)
        )
    return parts


def meshes():
    """(file under robots/, parts) of everything."""
    for name, parts in crichton():
        yield f"crichton/meshes/{name}.obj", parts
    for name, parts in hubo_middle():
        yield f"hubo/meshes/Body_{name}.obj", parts
    for name, parts in hubo_left():
        yield f"hubo/meshes/Body_L{name}.obj", parts
        yield f"hubo/meshes/Body_R{name}.obj", mirrored(parts)
    for name, parts in hubo_left_finger():
        yield f"hubo/meshes/Body_LFx{name}.obj", parts
        yield f"hubo/meshes/Body_RFx{name}.obj", mirrored(parts)
    for name, parts in person():
        yield f"person/meshes/{name}.obj", parts
    for name, parts in person_left():
        yield f"person/meshes/L{name}.obj", parts
        yield f"person/meshes/R{name}.obj", mirrored(parts)
    for make in (nine_sided_cup, table, cart, milk_carton, hammer, dog_plate, stool, dog):
        name = "cup" if make is nine_sided_cup else make.__name__
        yield f"objects/{name}/{name}.obj", make()


def main(arguments):
    if arguments not in ([], ["--check"]):
        raise SystemExit("usage: make_meshes.py [--check]")
    stale = []
    for name, parts in meshes():
        path, text = ROBOTS / name, text_of(name, parts)
        if not arguments:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="ascii")
        elif not path.exists() or path.read_text(encoding="ascii") != text:
            stale.append(name)
    if stale:
        raise SystemExit("out of date: " + ", ".join(stale))


if __name__ == "__main__":
    main(sys.argv[1:])
