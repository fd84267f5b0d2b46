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
    """Rectangle u x v (pairs of bounds) with its corners cut off; by default a regular octagon's cut."""
    if cut is None:
        cut = (1 - math.tan(math.pi / 8)) * min(u[1] - u[0], v[1] - v[0]) / 2
    return place(
        axis,
        at,
        [
            (u[0] + cut, v[0]), (u[1] - cut, v[0]), (u[1], v[0] + cut), (u[1], v[1] - cut),
            (u[1] - cut, v[1]), (u[0] + cut, v[1]), (u[0], v[1] - cut), (u[0], v[0] + cut),
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


def elbow_plate(z, radius, y, neck_y, neck_z, half_width):
    """The one-sided arm that carries the next joint's drum: a disc about (0, *, z) with a sloping neck."""
    return (
        disc("y", y[0], radius, (0, z))
        + disc("y", y[1], radius, (0, z))
        + [(s * half_width, neck_y, neck_z) for s in (-1, 1)]
        + [(s * half_width, y[1], neck_z) for s in (-1, 1)]
    )


def crichton():
    yield "L1", {
        "drum": drum("z", 0.066, 0.087, -0.097, 0.014),
        "plate": elbow_plate(-0.18, 0.0622, (-0.098, -0.0665), -0.064, -0.045, 0.045),
    }
    yield "L2", {
        "drum": drum("z", 0.066, -0.085, 0.090, 0.010),
        "neck": ring("y", 0.02, (-0.062, 0.062), (-0.066, 0.085))
        + ring("y", 0.070, (-0.060, 0.060), (-0.060, 0.085))
        + ring("y", 0.1175, (-0.052, 0.052), (-0.050, 0.062)),
    }
    yield "L3", {
        "drum": drum("z", 0.056, -0.0905, -0.252, 0.016),
        "plate": elbow_plate(-0.328, 0.0515, (-0.086, -0.0560), -0.054, -0.205, 0.038),
    }
    yield "L4", {
        "drum": drum("z", 0.056, -0.0785, 0.0785, 0.010),
        "neck": ring("y", 0.02, (-0.052, 0.052), (-0.058, 0.075))
        + ring("y", 0.066, (-0.046, 0.046), (-0.048, 0.075))
        + ring("y", 0.1065, (-0.042, 0.042), (-0.042, 0.053)),
    }
    yield "L5", {
        "drum": drum("z", 0.045, -0.081, -0.262, 0.015),
        "plate": elbow_plate(-0.323, 0.044, (-0.0935, -0.0470), -0.043, -0.215, 0.030),
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
    yield "TSY", {"pelvis": chamfered((-0.1145, 0.0705), (-0.1305, 0.1305), (-0.085, 0.015), 0.02)}
    yield "Torso", {"torso": chamfered((-0.151, 0.115), (-0.1415, 0.1435), (-0.0005, 0.2625), 0.03)}
    yield "NKY", {"neck": chamfered((-0.051, 0.015), (-0.0395, 0.0355), (0.0, 0.0705), 0.012)}
    yield "NK1", {
        "neck": chamfered((-0.024, 0.024), (-0.11, 0.015), (-0.040, 0.040), 0.010),
        "head": chamfered((-0.029, 0.029), (-0.191, -0.060), (-0.086, 0.086), 0.018),
    }
    yield "NK2", {"sensor": chamfered((-0.020, 0.040), (-0.0355, 0.0395), (-0.0555, 0.0255), 0.010)}


def hubo_left():
    """Links of the left side, frames of the robot's own joints; the right side is their mirror image."""
    yield "SP", {
        # Narrower towards the torso, so that it turns beside it.
        "shoulder": ring("y", 0.0, (-0.045, 0.045), (-0.038, 0.038))
        + ring("y", 0.045, (-0.058, 0.056), (-0.043, 0.043))
        + ring("y", 0.105, (-0.059, 0.057), (-0.043, 0.043))
        + ring("y", 0.140, (-0.050, 0.050), (-0.032, 0.032))
    }
    yield "SR", {
        "yoke": ring("z", 0.031, (-0.070, 0.002), (-0.026, 0.022))
        + ring("z", 0.005, (-0.084, 0.012), (-0.0415, 0.0335))
        + ring("z", -0.070, (-0.084, 0.012), (-0.0415, 0.0335))
        + ring("z", -0.091, (-0.072, 0.000), (-0.032, 0.026))
    }
    yield "SY", {
        "upper_arm": ring("z", 0.0, (-0.030, 0.030), (-0.033, 0.033))
        + ring("z", -0.115, (-0.034, 0.044), (-0.048, 0.038))
        + ring("z", -0.265, (-0.024, 0.058), (-0.044, 0.036))
        + ring("z", -0.302, (0.000, 0.052), (-0.036, 0.030))
    }
    yield "EP", {
        "elbow": prism(
            "y",
            (-0.0335, 0.0335),
            [(-0.012, 0.0265), (0.012, 0.0265), (0.026, 0.012), (0.026, -0.020)]
            + [(0.000, -0.0985), (-0.052, -0.0985), (-0.064, -0.088), (-0.064, -0.030)],
        )
    }
    yield "WY", {
        "forearm": chamfered((-0.029, 0.029), (-0.0265, 0.1245), (-0.215, 0.0), 0.018),
        # One-sided: it carries the wrist from its +y side and leaves the hand's sweep free.
        "wrist_drive": chamfered((-0.029, 0.029), (0.088, 0.1245), (-0.2925, -0.180), 0.012),
    }
    yield "WP", {
        "wrist": chamfered((-0.031, 0.031), (-0.031, 0.085), (-0.031, 0.036), 0.012),
        "motor": disc("z", 0.020, 0.0135) + disc("z", 0.145, 0.0135),
    }
    yield "WR", {
        "palm": disc("z", 0.0, 0.021)
        + ring("z", -0.040, (-0.036, 0.038), (-0.045, 0.043), 0.014)
        + ring("z", -0.0800, (-0.036, 0.038), (-0.045, 0.043), 0.014)
        + ring("z", -0.0905, (-0.030, 0.032), (-0.039, 0.037), 0.012)
    }
    yield "HY", {"hip": chamfered((-0.0505, 0.0825), (-0.045, 0.045), (-0.186, 0.0), 0.018)}
    yield "HR", {"hip": chamfered((-0.051, 0.057), (-0.059, 0.049), (-0.073, 0.047), 0.018)}
    yield "HP", {
        "thigh": ring("z", 0.0475, (-0.025, 0.060), (-0.045, 0.048))
        + ring("z", 0.010, (-0.047, 0.085), (-0.071, 0.069))
        + ring("z", -0.330, (-0.047, 0.085), (-0.071, 0.069))
        + ring("z", -0.3775, (-0.025, 0.060), (-0.050, 0.050))
    }
    yield "KP", {
        "shin": ring("z", 0.0365, (-0.020, 0.040), (-0.045, 0.045))
        + ring("z", 0.000, (-0.0425, 0.0645), (-0.068, 0.068))
        + ring("z", -0.330, (-0.0425, 0.0645), (-0.068, 0.068))
        + ring("z", -0.3725, (-0.020, 0.040), (-0.045, 0.045))
    }
    yield "AP", {"ankle": chamfered((-0.051, 0.075), (-0.059, 0.063), (-0.0425, 0.0705), 0.022)}
    yield "AR", {
        "foot": ring("z", -0.137, (-0.079, 0.141), (-0.069, 0.079), 0.020)
        + ring("z", -0.100, (-0.079, 0.141), (-0.069, 0.079), 0.020)
        + ring("z", -0.085, (-0.060, 0.115), (-0.050, 0.060), 0.020),
        "ankle": chamfered((-0.045, 0.060), (-0.050, 0.055), (-0.100, 0.037), 0.015),
    }


def hubo_left_finger():
    yield "1", {"phalanx": chamfered((-0.013, 0.013), (-0.021, -0.001), (-0.051, 0.011), 0.005)}
    yield "2", {"phalanx": chamfered((-0.011, 0.011), (-0.010, 0.010), (-0.0395, 0.0115), 0.005)}
    yield "3", {"phalanx": chamfered((-0.009, 0.009), (-0.010, 0.010), (-0.034, 0.008), 0.004)}


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
    x, y, top = 0.6096, 1.8288, 0.6731
    under = top - 0.025
    parts = {"top": box((0, x), (0, y), (under, top))}
    for i, (a, b) in enumerate([(0, 0), (x - 0.05, 0), (0, y - 0.05), (x - 0.05, y - 0.05)]):
        parts[f"leg_{i + 1}"] = box((a, a + 0.05), (b, b + 0.05), (0, under))
    for i, b in enumerate((0, y - 0.025)):
        parts[f"post_{i + 1}"] = box((0.292, 0.317), (b, b + 0.025), (under, 2.197))
    parts["sign"] = box((0.292, 0.317), (0.025, y - 0.025), (1.89, 2.197))
    return parts


def cart():
    """Origin: on the floor, as in the scenes; it covers x -0.012 .. 0.998, y 0.017 .. 0.567."""
    x, y, post = (0.078, 0.998), (0.032, 0.552), 0.030
    parts = {}
    for i, z in enumerate((0.190, 0.510, 0.817)):
        parts[f"shelf_{i + 1}"] = box(x, y, (z - 0.020, z))
    for i, (a, b) in enumerate([(x[0], 0.017), (x[1] - post, 0.017), (x[0], 0.537), (x[1] - post, 0.537)]):
        parts[f"post_{i + 1}"] = box((a, a + post), (b, b + post), (0, 0.820))
    for i, b in enumerate((0.017, 0.537)):
        parts[f"handle_post_{i + 1}"] = beam((-0.0, b + 0.015, 0.963), (-0.0, b + 0.015, 0.80), 0.012, 0.015)
        parts[f"handle_foot_{i + 1}"] = box((-0.012, x[0]), (b, b + post), (0.790, 0.820))
    parts["handle"] = box((-0.012, 0.012), (0.017, 0.567), (0.939, 0.963))
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
    feet, half_x, rail = -0.475, 0.1985, 0.0255
    parts = {}
    for i, (y, top, depth) in enumerate([(-0.251, 0.262, 0.143), (-0.129, 0.525, 0.143), (0.037, 0.787, 0.229)]):
        z = feet + top
        parts[f"step_{i + 1}"] = box((-0.173, 0.173), (y - depth / 2, y + depth / 2), (z - 0.03, z))
    for side, x in (("left", -half_x + rail / 2), ("right", half_x - rail / 2)):
        # The rail's ends are cut level, so the bounds in z are exact.
        parts[f"rail_{side}"] = [
            (x + s * rail / 2, y, z)
            for s in (-1, 1)
            for z, y0 in ((feet, -0.394), (0.605, 0.150))
            for y in (y0, y0 + 0.035)
        ]
        parts[f"leg_{side}"] = [
            (x + s * rail / 2, y, z)
            for s in (-1, 1)
            for z, y0 in ((feet, 0.218), (0.312, 0.140))
            for y in (y0 - 0.030, y0)
        ]
        # Brackets of the lower steps to the rail are part of the rail's own width.
    return parts


def dog():
    """Decor: standing, nose towards -y; origin as in the scenes, 0.42 above its paws."""
    parts = {
        "body": chamfered((-0.109, 0.109), (-0.090, 0.420), (-0.130, 0.090), 0.05),
        "neck": ring("z", 0.020, (-0.065, 0.065), (-0.110, 0.040))
        + ring("z", 0.150, (-0.055, 0.055), (-0.150, -0.040)),
        "head": chamfered((-0.075, 0.075), (-0.180, -0.020), (0.090, 0.243), 0.03),
        "muzzle": ring("y", -0.150, (-0.045, 0.045), (0.095, 0.175))
        + ring("y", -0.266, (-0.030, 0.030), (0.105, 0.150)),
        "tail": beam((0.0, 0.400, 0.060), (0.0, 0.505, 0.190), 0.018, 0.018)
        + [(0.0, 0.528, 0.185)],
    }
    for i, (x, y) in enumerate([(-0.070, -0.040), (0.070, -0.040), (-0.070, 0.370), (0.070, 0.370)]):
        parts[f"leg_{i + 1}"] = ring("z", -0.420, (x - 0.03, x + 0.03), (y - 0.035, y + 0.035)) + ring(
            "z", -0.080, (x - 0.035, x + 0.035), (y - 0.045, y + 0.045)
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
