#!/usr/bin/env python3
"""Writes the scenes that are too long to type: phalanx.test, spheres.test and ellipsoids.test.

    python3 scenes/generate.py [FOLDER]

FOLDER is this script's own unless named. The .test grammar has no loops, so sixty-four soldiers, a thousand spheres and
a flower's petals need one from outside. The files are committed: nothing needs this script, or Python, to build, to test
or to render. `unit` hashes integers where others would call a random number generator, so that every version of Python
writes the same bytes.
"""

import math
import sys
from pathlib import Path

FOLDER = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent


def unit(*key):
    """A number in [0, 1) that depends on the integers of the key only."""
    h = 0x811C9DC5
    for k in key:
        h = ((h ^ (k & 0xFFFFFFFF)) * 0x01000193) & 0xFFFFFFFF
        h ^= h >> 15
        h = (h * 0x2C1B3C6D) & 0xFFFFFFFF
        h ^= h >> 12
    return h / 2**32


def num(x):
    text = f"{x:.4f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


class Test:
    """A .test file in the making. Material commands are written only where a value changes."""

    DEFAULTS = {"ambient": (0.2, 0.2, 0.2), "diffuse": (0, 0, 0), "specular": (0, 0, 0), "shininess": (1,),
                "emission": (0, 0, 0), "transmission": (0, 0, 0), "ior": (1,)}

    def __init__(self, *comment):
        self.lines = [f"# {line}" for line in comment]
        self.state = dict(self.DEFAULTS)
        self.vertices = 0

    def put(self, command, *operands):
        self.lines.append(" ".join([command, *(o if isinstance(o, str) else num(o) for o in operands)]))

    def note(self, text):
        self.lines += ["", f"# {text}"]

    def surface(self, **values):
        """The whole material: what is not named is black."""
        wanted = {**self.DEFAULTS, "ambient": (0, 0, 0), **values}
        for name, value in wanted.items():
            value = tuple(value) if isinstance(value, (tuple, list)) else (value,)
            if self.state[name] != value:
                self.put(name, *value)
                self.state[name] = value

    def ellipsoid(self, centre, radii, turn=None):
        self.put("pushTransform")
        self.put("translate", *centre)
        if turn:
            self.put("rotate", *turn)
        self.put("scale", *radii)
        self.put("sphere", 0, 0, 0, 1)
        self.put("popTransform")

    def quad(self, a, b, c, d):
        """Corners counter-clockwise."""
        for corner in (a, b, c, d):
            self.put("vertex", *corner)
        n = self.vertices
        self.put("tri", n, n + 1, n + 2)
        self.put("tri", n, n + 2, n + 3)
        self.vertices += 4

    def save(self, name):
        (FOLDER / name).write_text("\n".join(self.lines) + "\n")


def mix(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def gradient(stops, t):
    """Piecewise linear between (position, colour) stops."""
    for (t0, a), (t1, b) in zip(stops, stops[1:]):
        if t <= t1:
            return mix(a, b, (t - t0) / (t1 - t0))
    return stops[-1][1]


# By the angle above the horizon, in degrees.
SKY = [(0, (1.00, 0.72, 0.40)), (4, (0.96, 0.58, 0.38)), (9, (0.74, 0.44, 0.43)), (16, (0.42, 0.34, 0.46)),
       (28, (0.18, 0.23, 0.39)), (50, (0.07, 0.10, 0.22)), (68, (0.03, 0.05, 0.12))]


def sky(t, radius, towards, bands):
    """A six-sided drum of emissive bands, one side facing the camera: the background, and what metal reflects.

    It is open above 68 degrees, for light from beyond.
    """
    corners = [towards + math.tau * (k + 0.5) / 6 for k in range(6)]
    ring = [(radius * math.cos(a), radius * math.sin(a)) for a in corners]
    degrees = [68 * (i / bands) ** 1.7 for i in range(bands + 1)]
    for low, high in zip(degrees, degrees[1:]):
        t.surface(emission=tuple(round(c, 3) for c in gradient(SKY, (low + high) / 2)))
        y0, y1 = (radius * math.tan(math.radians(d)) - 0.001 * (d == 0) for d in (low, high))
        for (x0, z0), (x1, z1) in zip(ring, ring[1:] + ring[:1]):
            t.quad((x0, y0, z0), (x0, y1, z0), (x1, y1, z1), (x1, y0, z1))


BRONZE = dict(ambient=(0.07, 0.045, 0.02), diffuse=(0.46, 0.28, 0.10), specular=(0.58, 0.43, 0.22), shininess=60)
DARK_BRONZE = dict(ambient=(0.03, 0.02, 0.01), diffuse=(0.20, 0.10, 0.04), specular=(0.30, 0.20, 0.10), shininess=30)
STEEL = dict(ambient=(0.03, 0.03, 0.04), diffuse=(0.20, 0.21, 0.23), specular=(0.55, 0.57, 0.60), shininess=90)
CREST = dict(ambient=(0.10, 0.01, 0.01), diffuse=(0.62, 0.06, 0.05), specular=(0.02, 0.02, 0.02), shininess=8)
CLOTH = dict(ambient=(0.05, 0.01, 0.01), diffuse=(0.30, 0.05, 0.05))
SKIN = dict(ambient=(0.05, 0.03, 0.02), diffuse=(0.40, 0.24, 0.16))
WOOD = dict(ambient=(0.04, 0.03, 0.02), diffuse=(0.34, 0.21, 0.11), specular=(0.03, 0.03, 0.03), shininess=12)


def soldier(t, rank, file):
    """One of sixty-four: facing +z, standing on y = 0, about 1.9 tall."""
    jitter = [unit(rank, file, k) - 0.5 for k in range(6)]
    t.note(f"rank {rank + 1}, file {file + 1}")
    t.put("pushTransform")
    t.put("translate", (file - 3.5) * 1.02 + 0.05 * jitter[0], 0, -rank * 1.25 + 0.08 * jitter[1])
    t.surface(**CLOTH)
    t.ellipsoid((0, 0.95, 0), (0.26, 0.52, 0.20))
    t.surface(**BRONZE)
    for side in (-1, 1):
        t.ellipsoid((0.14 * side, 0.30, 0.06 * side), (0.085, 0.32, 0.10))
    t.surface(**STEEL)
    t.ellipsoid((0, 1.62, 0.02), (0.17, 0.22, 0.20))
    t.surface(**CREST)
    t.ellipsoid((0, 1.86, -0.04), (0.035, 0.13, 0.26), (1, 0, 0, -8))
    # The spear stands in the right hand, leaning forward a little.
    t.put("pushTransform")
    t.put("translate", -0.40, 0, 0.16)
    t.put("rotate", 1, 0, 0, 7 + 3 * jitter[2])
    t.put("rotate", 0, 0, 1, 2.5 * jitter[3])
    t.surface(**WOOD)
    t.ellipsoid((0, 1.75, 0), (0.036, 1.85, 0.036))
    t.surface(**STEEL)
    t.ellipsoid((0, 3.55, 0), (0.06, 0.26, 0.03))
    t.put("popTransform")
    # The shield, on the left arm: rim, bowl, boss.
    t.put("pushTransform")
    t.put("translate", 0.10, 1.02, 0.36)
    t.put("rotate", 0, 1, 0, 8 + 6 * jitter[4])
    t.put("rotate", 1, 0, 0, -9 + 5 * jitter[5])
    t.surface(**DARK_BRONZE)
    t.ellipsoid((0, 0, 0), (0.50, 0.50, 0.045))
    t.surface(**BRONZE)
    t.ellipsoid((0, 0, 0), (0.43, 0.43, 0.13))
    t.surface(**STEEL)
    t.ellipsoid((0, 0, 0.11), (0.11, 0.11, 0.09))
    t.put("popTransform")
    t.put("popTransform")


def phalanx():
    t = Test("Eight ranks of eight at dawn, and what they face. Written by generate.py.")
    t.put("size", 1280, 720)
    t.put("maxdepth", 5)
    t.put("output", "phalanx.png")
    eye, at = (-6.1, 2.5, 8.9), (0.45, 1.18, -1.2)
    t.put("camera", *eye, *at, 0, 1, 0, 34)
    forward = math.atan2(at[2] - eye[2], at[0] - eye[0])

    t.note("The sun behind them on the right, the sky above, a fire on the left, and a lamp near the ground.")
    angle, distance = forward + math.radians(20.5), 90
    sun = (distance * math.cos(angle), 1.6, distance * math.sin(angle))
    t.put("point", 0.9 * sun[0], 9, 0.9 * sun[2], 0.85, 0.60, 0.35)
    t.put("directional", -0.12, 0.95, 0.20, 0.20, 0.24, 0.34)
    t.put("attenuation", 1, 0, 0.004)
    t.put("point", -13, 7, 11, 1.5, 1.15, 0.75)
    t.put("attenuation", 1, 0, 0.05)
    t.put("point", 4.5, 3.0, 6.0, 0.35, 0.40, 0.55)

    t.note("Sky, sun, hills.")
    sky(t, 120, forward, 128)
    t.surface(emission=(1, 0.93, 0.72))
    t.put("sphere", *sun, 3.6)
    for k in range(-9, 10):
        angle = forward + math.radians(4.2 * k + 3 * unit(k, 1))
        height = 2.2 + 4.5 * unit(k, 2)
        t.surface(emission=mix((0.36, 0.22, 0.28), (0.50, 0.30, 0.31), unit(k, 3)))
        t.ellipsoid((112 * math.cos(angle), 0, 112 * math.sin(angle)), (9 + 6 * unit(k, 4), height, 4),
                    (0, 1, 0, -90 - math.degrees(angle)))

    t.note("Ground: polished slabs near, one plain surface beyond.")
    stone = dict(specular=(0.36, 0.35, 0.34), shininess=120)
    side, reach = 2.0, 8
    for i in range(-reach, reach):
        for k in range(-reach, reach):
            shade = 0.13 if (i + k) % 2 else 0.19
            t.surface(ambient=(0.02, 0.02, 0.025), diffuse=(shade, shade * 0.95, shade * 0.92), **stone)
            x, z = i * side, k * side
            t.quad((x, 0, z), (x, 0, z + side), (x + side, 0, z + side), (x + side, 0, z))
    t.surface(ambient=(0.02, 0.02, 0.025), diffuse=(0.16, 0.152, 0.147), **stone)
    r, far = side * reach, 170
    t.quad((-far, 0, r), (-far, 0, far), (far, 0, far), (far, 0, r))
    t.quad((-far, 0, -far), (-far, 0, -r), (far, 0, -r), (far, 0, -far))
    t.quad((-far, 0, -r), (-far, 0, r), (-r, 0, r), (-r, 0, -r))
    t.quad((r, 0, -r), (r, 0, r), (far, 0, r), (far, 0, -r))

    for rank in range(8):
        for file in range(8):
            soldier(t, rank, file)

    t.note("What they face: glass, gold, silver.")
    glass = dict(specular=(0.08, 0.08, 0.08), shininess=200, transmission=(0.90, 0.93, 0.95), ior=1.5)
    t.surface(**glass)
    t.put("sphere", -1.75, 0.62, 3.6, 0.62)
    t.put("sphere", -0.75, 0.24, 4.25, 0.24)
    t.surface(ambient=(0.03, 0.02, 0), diffuse=(0.12, 0.08, 0.02), specular=(0.80, 0.60, 0.25), shininess=150)
    t.put("sphere", 0.1, 0.42, 3.3, 0.42)
    t.surface(diffuse=(0.03, 0.03, 0.03), specular=(0.85, 0.86, 0.88), shininess=300)
    t.put("sphere", 2.35, 0.75, 2.5, 0.75)
    t.save("phalanx.test")


PALETTE = [(0, (0.10, 0.12, 0.35)), (0.3, (0.12, 0.42, 0.55)), (0.55, (0.85, 0.72, 0.40)), (0.8, (0.85, 0.35, 0.18)),
           (1, (0.45, 0.08, 0.20))]


def spheres():
    t = Test("A thousand spheres, laid out as a sunflower lays out its seeds, on a wave. Written by generate.py.")
    t.put("size", 1280, 960)
    t.put("maxdepth", 5)
    t.put("output", "spheres.png")
    t.put("camera", 0, 14, 15.5, 0, -0.9, 1.5, 0, 1, 0, 46)
    t.put("directional", -0.5, 1, 0.3, 0.65, 0.62, 0.58)
    t.put("attenuation", 1, 0, 0.006)
    t.put("point", 6, 7, 4, 0.75, 0.65, 0.55)
    for n in range(1000):
        distance, angle = 0.31 * math.sqrt(n + 0.5), n * math.pi * (3 - math.sqrt(5))
        height = 0.9 * math.cos(distance * 1.35) * math.exp(-distance / 9)
        colour = gradient(PALETTE, (height + 0.75) / 1.65)
        t.surface(ambient=mix((0, 0, 0), colour, 0.12), diffuse=mix((0, 0, 0), colour, 0.8),
                  specular=(0.22, 0.22, 0.22), shininess=80)
        t.put("sphere", distance * math.cos(angle), height, distance * math.sin(angle), 0.30)
    t.save("spheres.test")


def ellipsoids():
    t = Test("Transforms: one unit sphere, turned, moved and stretched into every part of a flower.",
             "Each `rotate` between the petals adds to the one before; only what a petal needs for itself is pushed and",
             "popped. Written by generate.py.")
    t.put("size", 800, 600)
    t.put("maxdepth", 4)
    t.put("output", "ellipsoids.png")
    t.put("camera", 0, 5.4, 6.4, 0, 0.15, 0.15, 0, 1, 0, 36)
    t.put("directional", -0.4, 1, 0.75, 1.1, 1.0, 0.88)
    t.put("point", 5, 3, 5, 0.30, 0.34, 0.45)
    t.note("Water.")
    t.surface(ambient=(0.02, 0.05, 0.07), diffuse=(0.03, 0.10, 0.13), specular=(0.42, 0.46, 0.48), shininess=300)
    t.quad((-40, 0, -40), (-40, 0, 40), (40, 0, 40), (40, 0, -40))
    t.note("Leaves, flat on the water.")
    t.surface(ambient=(0.01, 0.04, 0.02), diffuse=(0.08, 0.34, 0.16), specular=(0.05, 0.06, 0.05), shininess=30)
    for x, z, r in ((-2.9, -0.9, 1.15), (2.7, -1.6, 1.3), (2.5, 1.5, 0.85), (-1.9, 2.0, 0.7), (-0.6, -3.6, 1.2)):
        t.ellipsoid((x, 0.02, z), (r, 0.05, 0.9 * r), (0, 1, 0, 40 * x))
    rings = ((14, 1.25, 12, (0.80, 0.30, 0.45)), (12, 1.00, 34, (0.86, 0.42, 0.55)), (9, 0.74, 56, (0.92, 0.58, 0.66)),
             (6, 0.48, 74, (0.96, 0.74, 0.76)))
    for count, length, lift, colour in rings:
        t.note(f"{count} petals, raised by {lift} degrees")
        t.surface(ambient=mix((0, 0, 0), colour, 0.14), diffuse=mix((0, 0, 0), colour, 0.8),
                  specular=(0.06, 0.05, 0.06), shininess=25)
        t.put("pushTransform")
        t.put("translate", 0, 0.18, 0)
        for _ in range(count):
            t.put("rotate", 0, 1, 0, 360 / count)
            t.put("pushTransform")
            t.put("rotate", 0, 0, 1, lift)
            t.put("translate", 0.25 + 0.72 * length, 0, 0)
            t.put("scale", 0.72 * length, 0.055, 0.27 * length)
            t.put("sphere", 0, 0, 0, 1)
            t.put("popTransform")
        t.put("popTransform")
    t.note("The heart, gold.")
    t.surface(ambient=(0.10, 0.07, 0.01), diffuse=(0.60, 0.42, 0.08), specular=(0.35, 0.28, 0.12), shininess=60)
    t.ellipsoid((0, 0.34, 0), (0.30, 0.22, 0.30))
    t.save("ellipsoids.test")


if __name__ == "__main__":
    phalanx()
    spheres()
    ellipsoids()
