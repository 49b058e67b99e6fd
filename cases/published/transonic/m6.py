#!/usr/bin/python3
"""Drag of the ONERA M6 wing at Mach 0.84 and a given lift, without friction: OpenFOAM's rhoSimpleFoam on half of the space.

    m6.py REQUEST RESULT                     an evaluation for Strake, in the current folder
    m6.py prepare                            the wing, and mesh and flow about it, in generated/
    m6.py polar FACTOR FILE LIFT..           angle of attack and drag of a surface at each lift, on a mesh of FACTOR times the resolution

The mesh is made about the start, and moved with the surface; cells at the wall are 0.5 % of the chord high. The angle of attack turns the
stream, not the mesh, and is corrected on the way to the lift that is asked for. Coefficients are those of the
half wing on its area. The slope of the pressure at the wall is the one that bends the stream along it: with none, as OpenFOAM's walls have
it, the leading edge loses 15 % of the total pressure.
Needs: scripts/setup.sh openfoam
"""
import json
import math
import os
import re
import shutil
import sys

sys.dont_write_bytecode = True
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np  # noqa: E402

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path[:0] = [os.path.join(HERE, ".."), os.path.join(HERE, "../../external/openfoam")]
import around_wing  # noqa: E402
import flow  # noqa: E402
import foam  # noqa: E402
import surfaces  # noqa: E402
from mesh import Mesh  # noqa: E402

TEMPLATE, GENERATED = os.path.join(HERE, "foam"), os.path.join(HERE, "../generated")
BASE, START = os.path.join(GENERATED, "transonic"), os.path.join(GENERATED, "onera_m6.obj")
CELLS = {"chord": 28, "wake": 8, "span": 10, "tip": 3, "outward": 18}
FIRST = 6e-3  # thickness of the cells at the wall
MACH, LIFT = 0.84, 0.29
LIFT_SLOPE, DRAG_BY_LIFT = 6.0, 0.08  # per radian; at this lift: what is left to the lift asked for is corrected by these
SHARPEST = 40.0  # bend of the wall, 1/length: beyond, at the rim of the tip, cells are too coarse for it
MORE = 3  # times that the last iterations are repeated where the lift is not there
MEAN = 10  # iterations that coefficients are averaged over
FIELDS = ["U", "p", "T"]


class Layout(around_wing.Layout):
    """Of the M6: its section, and cells that are close at both edges."""

    def section(self, x):
        return np.array([surfaces.onera_d(k) for k in x])

    def along(self, m):
        return 0.5 * (1 - np.cos(np.pi * m ** 1.15))

    def lean(self, m, x):
        return 1 - x ** 2


def layout(factor):
    return Layout(flow.refined(CELLS, factor), FIRST / factor)


def write_stream(folder, alpha):
    with open(os.path.join(folder, "system/stream"), "w", encoding="ascii") as file:
        c, s = math.cos(alpha), math.sin(alpha)
        file.write(f"mach {MACH!r};\nstream ({MACH * c!r} 0 {MACH * s!r});\nalong ({c!r} 0 {s!r});\nupward ({-s!r} 0 {c!r});\n")


def wall_bend(mesh, faces, corners):
    """By how much the normals n of the wall's faces, out of the fluid, turn: G with n(x + d) = n(x) + G d, from the faces beside each one."""
    normal = mesh.areas[faces] / np.linalg.norm(mesh.areas[faces], axis=1)[:, None]
    centre, beside, edges = mesh.centres[faces], [[] for _ in faces], {}
    for k, face in enumerate(corners):
        for a, b in zip(face.tolist(), np.roll(face, 1).tolist()):
            edges.setdefault((min(a, b), max(a, b)), []).append(k)
    for pair in edges.values():
        if len(pair) == 2 and normal[pair[0]] @ normal[pair[1]] > 0.2:  # not across the trailing edge
            beside[pair[0]].append(pair[1])
            beside[pair[1]].append(pair[0])
    bend = np.zeros((len(faces), 3, 3))
    for k, others in enumerate(beside):
        apart = centre[others] - centre[k]
        apart -= np.outer(apart @ normal[k], normal[k])
        size = np.linalg.norm(apart, axis=1)[:, None]
        g = np.linalg.lstsq(apart / size, (normal[others] - normal[k]) / size, rcond=0.2)[0]
        bend[k] = g.T * min(1, SHARPEST / max(np.abs(np.linalg.eigvalsh(0.5 * (g + g.T))).max(), 1e-9))
    return bend


class Case:
    """A case of OpenFOAM's about a wing."""

    def __init__(self, folder, alpha):
        self.folder, self.alpha = folder, alpha
        where = os.path.join(folder, "constant/polyMesh")
        mesh, faces = Mesh.read(where), foam.patch_range(where, "body")
        if mesh.volumes.min() <= 0:
            foam.fail("the mesh turns inside out on this shape")
        self.bend = wall_bend(mesh, faces, foam.read_patch(where, "body"))

    def write(self, name, text):
        """A field of the last time; never into a file of the base's."""
        path = os.path.join(self.folder, flow.latest(self.folder), name)
        if os.path.lexists(path):
            os.remove(path)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)

    def read(self, name):
        with open(os.path.join(self.folder, flow.latest(self.folder), name), encoding="ascii") as file:
            return file.read()

    def set_boundary(self):
        """What a written field holds as numbers: the far field's direction; at the wall, the slope of the pressure that bends the stream."""
        write_stream(self.folder, self.alpha)
        far = f" type freestreamVelocity; freestreamValue uniform ({MACH * math.cos(self.alpha)!r} 0 {MACH * math.sin(self.alpha)!r});"
        self.write("U", re.sub(r"(\n\s*far\s*\{)[^}]*\}", lambda found: found[1] + far + " value $freestreamValue; }", self.read("U")))
        path = os.path.join(self.folder, flow.latest(self.folder), "p")
        at_wall = "uniform 1"
        if "exprMixed" in self.read("p"):
            values = foam.numbers(re.search(rb"\bbody\s*\{[^}]*?\bvalue\s+nonuniform[^(]*\(([^)]*)\)", foam.body_of(path))[1])
            # Not as List<scalar>, which this condition could not read twice, as it does:
            at_wall = f"nonuniform {len(values)}\n(\n" + "\n".join(map(repr, values.tolist())) + "\n)"
        wall = f' type exprMixed; valueExpr "0"; fractionExpr "0.0"; gradientExpr "1.4 * p / T * (U & (wallBend & U))"; value {at_wall};'
        self.write("p", re.sub(r"(\n\s*body\s*\{)[^}]*\}", lambda found: found[1] + wall + " }", self.read("p")))
        rows = "\n".join("(" + " ".join(map(repr, g.ravel().tolist())) + ")" for g in self.bend)
        none = "uniform (0 0 0 0 0 0 0 0 0)"
        self.write("wallBend", foam.header("volTensorField", "wallBend") + f"dimensions [0 -1 0 0 0 0 0];\ninternalField {none};\nboundaryField\n"
                   f"{{\n    symmetry {{ type symmetryPlane; }}\n    far {{ type calculated; value {none}; }}\n"
                   f"    body {{ type calculated; value nonuniform List<tensor> {len(self.bend)}\n(\n{rows}\n); }}\n}}\n")

    def solve(self, lift, counts):
        """Angle of attack and drag at this lift: after so many iterations the angle is corrected, and after the last ones, too, while more than
        1.5 % of the lift is missing. What is left is corrected in the drag."""
        last = int(flow.latest(self.folder))
        for k, count in enumerate((*counts, *(MORE * (counts[-1],)))):
            self.set_boundary()
            last += count
            flow.steps(self.folder, last)
            foam.run(self.folder, "rhoSimpleFoam")
            found, drag = (float(flow.coefficients(self.folder, name)[-MEAN:].mean()) for name in ("Cl", "Cd"))
            if os.environ.get("M6_VERBOSE"):
                print(f"{last}: {math.degrees(self.alpha):.4f} degrees, lift {found:.6f}, drag {drag:.6f}", flush=True)
            if k >= len(counts) - 1 and abs(found - lift) < 0.015 * lift:
                break
            if k < len(counts) + MORE - 1:
                self.alpha += (lift - found) / LIFT_SLOPE
        else:
            foam.fail(f"lift {found:.5g} after {last} iterations, {lift:g} asked for")
        return self.alpha, drag + DRAG_BY_LIFT * (lift - found)


def build(folder, surface, factor):
    """A mesh about the surface, tied to it; returns the number of cells."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(TEMPLATE, folder)
    made, mesh = layout(factor), os.path.join(folder, "constant/polyMesh")
    carried, on_wing, _ = made.wing(surface)
    points = made.points(on_wing)
    around_wing.write_topology(mesh, made, points)
    foam.write_points(mesh, points)
    np.savez(os.path.join(folder, "map.npz"), vertices=surface[0], corners=carried.corners, weights=carried.weights,
             on_wing=on_wing, factor=factor)
    write_stream(folder, 0.05)
    return flow.check(folder)


def zero_lift_angle(on_wing, shift):
    """By how much the shift of the points on the wing turns the direction of no lift: thin airfoils (M. Munk 1922), the mean over the area."""
    rows = int(np.argmax(np.diff(on_wing[:, 1]) < 0)) + 1
    at, moved = (a.reshape(-1, rows, 3) for a in (on_wing, shift))
    count = len(at) // 2  # of cells along each side; points go from the trailing edge below to the nose and back above
    front, last = at[count], at[0]
    chord = last[:, 0] - front[:, 0]
    x = np.clip((at[count:, :, 0] - front[:, 0]) / chord, 0, 1)
    camber = (moved[count:, :, 2] + moved[count::-1, :, 2]) / (2 * chord)
    turn = np.arccos(1 - 2 * x)
    integrand = np.diff(camber, axis=0) / np.maximum(np.diff(x, axis=0), 1e-9) * (np.cos(0.5 * (turn[1:] + turn[:-1])) - 1)
    angle = -np.sum(integrand * np.diff(turn, axis=0), axis=0) / np.pi
    width = np.gradient(on_wing.reshape(-1, rows, 3)[count, :, 1]) * chord
    return float(angle @ width / width.sum())


def move(base, folder, vertices):
    """The base's case in `folder` with the mesh about a wing of the same vertices; returns by how much its angle of attack is another one."""
    stored, carried = flow.read_map(base)
    if len(vertices) != carried.num_vertices:
        foam.fail(f"the surface has {len(vertices)} vertices, the start {carried.num_vertices}")
    shutil.rmtree(folder, ignore_errors=True)
    flow.clone(base, folder)
    shift = carried.apply(vertices - stored["vertices"])
    shift[stored["on_wing"][:, 1] == 0, 1] = 0
    os.remove(os.path.join(folder, "constant/polyMesh/points"))  # the base's
    foam.write_points(os.path.join(folder, "constant/polyMesh"), layout(float(stored["factor"])).points(stored["on_wing"] + shift))
    return zero_lift_angle(stored["on_wing"], shift)


def alpha_of(base):
    with open(os.path.join(base, "alpha"), encoding="ascii") as file:
        return float(file.read())


def start_case(folder, factor, lift, counts):
    """Mesh and flow about the start."""
    cells = build(folder, foam.read_obj(START), factor)
    alpha, drag = Case(folder, 0.05).solve(lift, counts)
    with open(os.path.join(folder, "alpha"), "w", encoding="ascii") as file:
        file.write(repr(alpha))
    flow.start_from(folder, FIELDS)
    return cells, alpha, drag


def evaluate(request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        surface = foam.read_obj(json.load(file)["surface"])
    if not os.path.exists(os.path.join(BASE, "alpha")):
        foam.fail(f"{BASE}: no flow yet; run m6.py prepare first")
    turn = move(BASE, "case", surface[0])
    alpha, drag = Case("case", alpha_of(BASE) + turn).solve(LIFT, (35, 30, 45))
    with open(result_file, "w", encoding="ascii") as file:
        json.dump({"values": {"drag": drag}, "info": {"alpha": alpha}}, file)
    flow.clean("case")


def prepare():
    os.makedirs(GENERATED, exist_ok=True)
    surfaces.KINDS["onera_m6"](6000).write(START)
    cells, alpha, drag = start_case(BASE, 1, LIFT, (250, 150, 150))
    print(f"{cells} cells, {math.degrees(alpha):.4f} degrees, drag {drag:.6f}")


def polar(factor, file, lifts):
    """Lift after lift, each from the flow of the one before."""
    base = f"polar-base-{factor}"
    if not os.path.exists(os.path.join(base, "alpha")):
        start_case(base, float(factor), LIFT, (250, 150, 150))
    turn = move(base, "polar", foam.read_obj(file)[0])
    case = Case("polar", alpha_of(base) + turn)
    for lift in lifts:
        alpha, drag = case.solve(float(lift), (70, 60))
        print(f"{file}: lift {float(lift):g}, {math.degrees(alpha):.4f} degrees, drag {drag:.6f}", flush=True)
    shutil.rmtree("polar")


def main():
    if sys.argv[1:] == ["prepare"]:
        prepare()
    elif len(sys.argv) > 4 and sys.argv[1] == "polar":
        polar(sys.argv[2], sys.argv[3], sys.argv[4:])
    elif len(sys.argv) == 3:
        evaluate(sys.argv[1], sys.argv[2])
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
