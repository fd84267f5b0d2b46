#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws one moment of a plan file, or a dumped state, to look at what a plan really does: the collision shapes of the
whole cell, flat-shaded, each robot in its colour, the object green.

    render_plan.py plan.json --stage "hubo/left grasp" --camera 1.6 -2.2 1.9  0.2 -0.4 0.9 --zoom 1.5 --output a.png
    render_plan.py state.obj --object cup --output b.png         what `handoverctl plan --dump-state` has written

The moment is the end of a stage ("hubo/left grasp", or "grasp.1" as --dump-state has it; `start` and `end` mean the
plan's) or a time; of a file without a plan it is the start. The camera is two points, from and at, in the world;
--hide takes away what stands in the view. Writes PNG, in less than a second. Needs nothing but Python.
"""

import argparse
import json
import math
import pathlib
import struct
import sys
import xml.etree.ElementTree as ElementTree
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# Of the robots that hold the object, in the order in which they do; of others.
ROBOT_COLOURS = [(0.95, 0.60, 0.25), (0.35, 0.55, 0.95), (0.75, 0.45, 0.85), (0.90, 0.45, 0.55)]
IDLE_COLOUR = (0.72, 0.75, 0.78)
OBJECT_COLOUR = (0.15, 0.80, 0.25)
FURNITURE = [(0.72, 0.66, 0.58), (0.62, 0.68, 0.70), (0.75, 0.72, 0.55), (0.80, 0.45, 0.45), (0.55, 0.50, 0.45)]
FLOOR_COLOUR = (0.82, 0.82, 0.80)
LIGHT = (0.35, -0.55, 0.76)
NEAR = 0.05
IDENTITY = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0))


# --- poses: three rows of four ------------------------------------------------------------------------


def compose(a, b):
    return tuple(
        tuple(sum(r[k] * b[k][c] for k in range(3)) + (r[3] if c == 3 else 0) for c in range(4)) for r in a
    )


def move(X, p):
    return tuple(r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3] for r in X)


def inverse(X):
    R = [[X[c][r] for c in range(3)] for r in range(3)]
    return tuple((*R[r], -sum(R[r][k] * X[k][3] for k in range(3))) for r in range(3))


def of_quaternion(pose):
    w, x, y, z = pose["quat_wxyz"]
    p = pose["xyz"]
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), p[0]),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), p[1]),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), p[2]),
    )


def of_axis(axis, angle, p=(0, 0, 0)):
    n = math.sqrt(sum(a * a for a in axis))
    s = math.sin(angle / 2) / n
    return of_quaternion({"quat_wxyz": (math.cos(angle / 2), *(a * s for a in axis)), "xyz": p})


def of_origin(element):
    origin = element.find("origin")
    if origin is None:
        return IDENTITY
    xyz = numbers(origin.get("xyz", "0 0 0"))
    roll, pitch, yaw = numbers(origin.get("rpy", "0 0 0"))
    X = compose(of_axis((0, 0, 1), yaw, xyz), of_axis((0, 1, 0), pitch))
    return compose(X, of_axis((1, 0, 0), roll))


def numbers(text):
    return tuple(float(word) for word in text.split())


# --- shapes: lists of triangles, corners counter-clockwise from outside -------------------------------


def box(size):
    triangles = []
    for k in range(3):
        for side in (-1, 1):
            corners = []
            for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))[::side]:
                signs = {k: side, (k + 1) % 3: u, (k + 2) % 3: v}
                corners.append(tuple(signs[i] * size[i] / 2 for i in range(3)))
            triangles += [(corners[0], corners[1], corners[2]), (corners[0], corners[2], corners[3])]
    return triangles


def revolved(profile, n=24):
    """The solid of a profile of (radius, z) turned about z; z rises."""
    rings = [
        [(r * math.cos(2 * math.pi * i / n), r * math.sin(2 * math.pi * i / n), z) for i in range(n)]
        for r, z in profile
    ]
    triangles = []
    for low, high in zip(rings, rings[1:]):
        for i in range(n):
            j = (i + 1) % n
            triangles += [(low[i], low[j], high[j]), (low[i], high[j], high[i])]
    return triangles


def obj(path, scale=(1, 1, 1)):
    points, triangles = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append(tuple(float(w) * s for w, s in zip(words[1:4], scale)))
        elif words[:1] == ["f"]:
            face = [points[int(w.split("/")[0]) - 1] for w in words[1:]]
            triangles += [(face[0], a, b) for a, b in zip(face[1:], face[2:])]
    return triangles


def sphere(r, n=12):
    return revolved([(r * math.sin(math.pi * i / n), -r * math.cos(math.pi * i / n)) for i in range(n + 1)])


def cylinder(r, length):
    return revolved([(0, -length / 2), (r, -length / 2), (r, length / 2), (0, length / 2)])


def shape(geometry, root):
    kind = geometry["type"]
    if kind == "compound":
        return [
            tuple(move(of_quaternion(part["X_OS"]), p) for p in triangle)
            for part in geometry["parts"]
            for triangle in shape(part["geometry"], root)
        ]
    if kind == "box":
        return box(geometry["size"])
    if kind == "sphere":
        return sphere(geometry["radius"])
    if kind == "cylinder":
        return cylinder(geometry["radius"], geometry["length"])
    return obj(root / geometry["path"], geometry["scale"])


def urdf_shape(element, folder):
    shape_element = element.find("geometry")[0]
    if shape_element.tag == "box":
        triangles = box(numbers(shape_element.get("size")))
    elif shape_element.tag == "sphere":
        triangles = sphere(float(shape_element.get("radius")))
    elif shape_element.tag == "cylinder":
        triangles = cylinder(float(shape_element.get("radius")), float(shape_element.get("length")))
    else:
        path = folder / shape_element.get("filename")
        triangles = obj(path, numbers(shape_element.get("scale", "1 1 1")))
    X = of_origin(element)
    return [tuple(move(X, p) for p in triangle) for triangle in triangles]


# --- robot --------------------------------------------------------------------------------------------


class Robot:
    def __init__(self, record, root):
        path = root / record["urdf"]
        tree = ElementTree.parse(path).getroot()
        self.X_WB = of_quaternion(record["X_WB"])
        self.joints = {j.find("child").get("link"): j for j in tree.findall("joint")}
        self.links = {}
        for link in tree.findall("link"):
            shapes = [urdf_shape(c, path.parent) for c in link.findall("collision")]
            self.links[link.get("name")] = [triangle for part in shapes for triangle in part]

    def pose(self, link, q):
        """X_WL at the joint positions q, by name; mimic joints follow their law."""
        joint = self.joints.get(link)
        if joint is None:
            return self.X_WB
        X = compose(self.pose(joint.find("parent").get("link"), q), of_origin(joint))
        if joint.get("type") == "fixed":
            return X
        mimic = joint.find("mimic")
        if mimic is None:
            value = q[joint.get("name")]
        else:
            value = float(mimic.get("multiplier", 1)) * q[mimic.get("joint")] + float(mimic.get("offset", 0))
        axis = numbers(joint.find("axis").get("xyz"))
        if joint.get("type") == "prismatic":
            return compose(X, tuple(row[:3] + (a * value,) for row, a in zip(IDENTITY, axis)))
        return compose(X, of_axis(axis, value))


# --- plan ---------------------------------------------------------------------------------------------


def quintic(s, h, start, end):
    """The curve of (q, qd, qdd) at two samples h apart, at s from 0 to 1."""
    (q0, v0, a0), (q1, v1, a1) = start, end
    d, v, w, a, b = q1 - q0, v0 * h, v1 * h, a0 * h * h, a1 * h * h
    c3 = 10 * d - 6 * v - 4 * w - 1.5 * a + 0.5 * b
    c4 = -15 * d + 8 * v + 7 * w + 1.5 * a - b
    c5 = 6 * d - 3 * (v + w) + 0.5 * (b - a)
    return q0 + s * (v + s * (a / 2 + s * (c3 + s * (c4 + s * c5))))


def sample(stage, t):
    """q of a stage at t from its start; before and after it stands still."""
    times = stage["t"]
    t = min(max(t, times[0]), times[-1])
    i = next(k for k in range(1, len(times)) if t <= times[k])
    h = times[i] - times[i - 1]
    rows = [stage[key][k] for k in (i - 1, i) for key in ("q", "qd", "qdd")]
    return [quintic((t - times[i - 1]) / h, h, column[:3], column[3:]) for column in zip(*rows)]


def ends_at(stage):
    return stage["start"] + stage["t"][-1]


class Motion:
    """What moves in a plan file, and when."""

    def __init__(self, file):
        plan = file["plan"] or {"holders": [], "stages": []}
        self.scene = file["scene"]
        self.holders = plan["holders"]
        self.stages = sorted(plan["stages"], key=lambda s: s["start"])
        self.end = max((ends_at(stage) for stage in self.stages), default=0.0)
        # From the end of a holder's grasp, or the start, to the end of its release, or for good.
        self.holds = []
        for k in range(len(self.holders)):
            self.holds.append((self.end_of(k, "grasp", 0.0), self.end_of(k, "release", math.inf)))

    def end_of(self, holder, action, otherwise):
        return next((ends_at(s) for s in self.stages if (s["holder"], s["action"]) == (holder, action)), otherwise)

    def label(self, stage):
        holder = self.holders[stage["holder"]]
        return f"{holder['robot']}/{holder['arm']} {stage['action']}"

    def joints(self, t):
        q = {robot["name"]: dict(robot["q_start"]) for robot in self.scene["robots"]}
        for stage in self.stages:
            if stage["start"] <= t:
                q[stage["robot"]].update(zip(stage["joints"], sample(stage, t - stage["start"])))
        return q

    def colour(self, robot):
        order = list(dict.fromkeys(holder["robot"] for holder in self.holders))
        return ROBOT_COLOURS[order.index(robot) % len(ROBOT_COLOURS)] if robot in order else IDLE_COLOUR

    def planned_object(self, robots, t):
        """Where the object is that is brought: with who holds it, else where it stands."""
        put_down = self.holds[-1][1] if self.holds else math.inf
        t = min(t, put_down)
        for holder, (begin, end) in zip(self.holders, self.holds):
            if begin <= t and (t < end or t == put_down == end):
                X_WT = robots[holder["robot"]].pose(holder["tool_link"], self.joints(t)[holder["robot"]])
                return compose(X_WT, inverse(of_quaternion(holder["X_OT"])))
        return of_quaternion(self.scene["start"]["X_WO"])

    def place(self, thing, robots, t):
        if thing["name"] == self.scene["object"]:
            return self.planned_object(robots, t)
        hold = thing["attached_to"]
        if hold is None:
            return of_quaternion(thing["X_WO"])
        X_WL = robots[hold["robot"]].pose(hold["link"], self.joints(t)[hold["robot"]])
        return compose(X_WL, of_quaternion(hold["X_LO"]))


def triangles_at(motion, root, t, hidden):
    """(corners in the world, colour) of everything."""
    scene = motion.scene
    robots = {record["name"]: Robot(record, root) for record in scene["robots"]}
    q = motion.joints(t)
    bodies = []
    for name, robot in robots.items():
        for link, triangles in robot.links.items():
            if not hidden & {name, f"{name}/{link}"}:
                bodies.append((robot.pose(link, q[name]), triangles, motion.colour(name)))
    for i, thing in enumerate(scene["objects"]):
        name = thing["name"]
        colour = {scene["object"]: OBJECT_COLOUR, "floor": FLOOR_COLOUR}.get(name, FURNITURE[i % len(FURNITURE)])
        if name not in hidden:
            bodies.append((motion.place(thing, robots, t), shape(thing["geometry"], root), colour))
    return [(tuple(move(X, p) for p in corners), colour) for X, shapes, colour in bodies for corners in shapes]


def triangles_of(state, thing, hidden):
    """The same from a dumped state: its groups are named robot/link or by object."""
    points, triangles, robots, furniture = [], [], [], []
    for line in state.read_text().splitlines():
        words = line.split()
        if words[:1] == ["o"]:
            robot, link, _ = words[1].partition("/")
            known = robots if link else furniture
            if robot not in known:
                known.append(robot)
            palette = ROBOT_COLOURS if link else FURNITURE
            colour = palette[known.index(robot) % len(palette)]
            colour = {thing: OBJECT_COLOUR, "floor": FLOOR_COLOUR}.get(words[1], colour)
            seen = not hidden & {robot, words[1]}
        elif words[:1] == ["v"]:
            points.append(tuple(float(word) for word in words[1:4]))
        elif words[:1] == ["f"] and seen:
            triangles.append((tuple(points[int(word) - 1] for word in words[1:]), colour))
    return triangles


# --- picture ------------------------------------------------------------------------------------------


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def unit(a):
    n = math.sqrt(dot(a, a))
    return (a[0] / n, a[1] / n, a[2] / n) if n > 1e-15 else (0.0, 0.0, 0.0)


def clipped(points):
    """Polygon in the camera's frame without what is nearer than NEAR."""
    kept = []
    for a, b in zip(points, points[1:] + points[:1]):
        if a[2] >= NEAR:
            kept.append(a)
        if (a[2] >= NEAR) != (b[2] >= NEAR):
            s = (NEAR - a[2]) / (b[2] - a[2])
            kept.append(tuple(x + s * (y - x) for x, y in zip(a, b)))
    return kept


def fill(picture, depth, width, height, corners, rgb):
    """Triangle of (x, y, 1 / z) on the picture; nearer, that is greater 1 / z, wins."""
    (x0, y0, w0), (x1, y1, w1), (x2, y2, w2) = corners
    area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    if abs(area) < 1e-9:
        return
    wx = ((w1 - w0) * (y2 - y0) - (w2 - w0) * (y1 - y0)) / area
    wy = ((x1 - x0) * (w2 - w0) - (x2 - x0) * (w1 - w0)) / area
    edges = ((x0, y0, x1, y1), (x1, y1, x2, y2), (x2, y2, x0, y0))
    for y in range(max(0, math.ceil(min(y0, y1, y2))), min(height, math.ceil(max(y0, y1, y2)))):
        cuts = [xa + (y - ya) * (xb - xa) / (yb - ya) for xa, ya, xb, yb in edges if (ya <= y) != (yb <= y)]
        if len(cuts) < 2:
            continue
        first, last = max(0, math.ceil(min(cuts))), min(width, math.ceil(max(cuts)))
        w = w0 + wx * (first - x0) + wy * (y - y0)
        for at in range(y * width + first, y * width + last):
            if w > depth[at]:
                depth[at] = w
                picture[at] = rgb
            w += wx


def render(triangles, eye, at, zoom, width, height):
    forward = unit(sub(at, eye))
    right = unit(cross(forward, (0, 0, 1) if abs(forward[2]) < 0.999 else (0, 1, 0)))
    down = cross(forward, right)
    focal = zoom * height
    depth = [0.0] * (width * height)
    picture = [bytes((245, 248, 252))] * (width * height)
    light = unit(LIGHT)
    for corners, colour in triangles:
        normal = unit(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])))
        if dot(normal, sub(eye, corners[0])) <= 0:
            continue
        shade = 0.45 + 0.40 * max(0.0, dot(normal, light)) + 0.15 * abs(dot(normal, forward))
        rgb = bytes(min(255, int(255 * c * shade)) for c in colour)
        seen = clipped([(dot(d, right), dot(d, down), dot(d, forward)) for d in (sub(p, eye) for p in corners)])
        flat = [(width / 2 + focal * x / z, height / 2 + focal * y / z, 1 / z) for x, y, z in seen]
        for a, b in zip(flat[1:], flat[2:]):
            fill(picture, depth, width, height, (flat[0], a, b), rgb)
    return picture


def png(picture, width, height):
    def chunk(tag, data):
        return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))

    rows = b"".join(b"\0" + b"".join(picture[y * width : (y + 1) * width]) for y in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def moment(motion, arguments):
    if arguments.time is not None:
        return arguments.time
    moments = {"start": 0.0}
    for stage in motion.stages:
        moments.setdefault(motion.label(stage), ends_at(stage))
    named = {f"{stage['action']}.{stage['holder']}": ends_at(stage) for stage in motion.stages}
    moments["end"] = motion.end
    if arguments.stage not in moments | named:
        sys.exit(f"no stage {arguments.stage}; there are {', '.join(moments)}")
    return (moments | named)[arguments.stage]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plan", type=pathlib.Path)
    when = parser.add_mutually_exclusive_group()
    when.add_argument("--stage", default="start")
    when.add_argument("--time", type=float)
    parser.add_argument("--camera", type=float, nargs=6, default=(2.6, -2.6, 2.2, 0.3, -0.3, 0.8))
    parser.add_argument("--zoom", type=float, default=1.0)
    parser.add_argument("--size", type=int, nargs=2, default=(960, 720))
    parser.add_argument("--hide", action="append", default=[], help="a robot, a robot/link, an object")
    parser.add_argument("--object", help="what is brought, in a dumped state")
    parser.add_argument("--root", type=pathlib.Path, default=ROOT)
    parser.add_argument("--output", type=pathlib.Path, default=pathlib.Path("plan.png"))
    arguments = parser.parse_args()
    hidden = set(arguments.hide)
    if arguments.plan.suffix == ".obj":
        triangles = triangles_of(arguments.plan, arguments.object, hidden)
    else:
        file = json.loads(arguments.plan.read_text())
        if file.get("format") != "handover-plan/2":
            sys.exit(f"{arguments.plan}: is no plan file of the format handover-plan/2")
        motion = Motion(file)
        triangles = triangles_at(motion, arguments.root, moment(motion, arguments), hidden)
    camera = arguments.camera
    picture = render(triangles, camera[:3], camera[3:], arguments.zoom, *arguments.size)
    arguments.output.write_bytes(png(picture, *arguments.size))


if __name__ == "__main__":
    main()
