"""Makes solids for the models of this folder (boxes, prisms, curved walls) and writes OBJ and DAE files.

Lengths are in metres, and z is up. The winding of the faces makes the normals point out of the material.
"""
import math


class Mesh:
    """Polygons, each with the name of its material."""

    def __init__(self):
        self.vertices = []
        self.faces = []  # (material, vertex numbers)
        self._numbers = {}

    def vertex(self, point):
        key = tuple(round(c, 6) + 0.0 for c in point)
        if key not in self._numbers:
            self._numbers[key] = len(self.vertices)
            self.vertices.append(key)
        return self._numbers[key]

    def face(self, material, points):
        self.faces.append((material, [self.vertex(p) for p in points]))

    def add(self, other, at=(0, 0, 0), yaw_deg=0):
        c, s = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
        for material, numbers in other.faces:
            points = [other.vertices[n] for n in numbers]
            self.face(material, [(c * x - s * y + at[0], s * x + c * y + at[1], z + at[2])
                                 for x, y, z in points])
        return self


def boxes(*operations):
    """The surface of boxes that are added or cut out one after the other.

    An operation is (material, low corner, high corner). The material None cuts the box out. Between boxes
    that touch there is no face and no edge, because the surface is built on the grid of all their planes.
    """
    planes = [sorted({round(c[axis], 6) for _, low, high in operations for c in (low, high)})
              for axis in range(3)]
    size = [len(p) - 1 for p in planes]
    cell = {}
    for material, low, high in operations:
        spans = [range(planes[a].index(round(low[a], 6)), planes[a].index(round(high[a], 6)))
                 for a in range(3)]
        for i in spans[0]:
            for j in spans[1]:
                for k in spans[2]:
                    cell[i, j, k] = material
    mesh = Mesh()
    for i in range(size[0]):
        for j in range(size[1]):
            for k in range(size[2]):
                material = cell.get((i, j, k))
                if material is None:
                    continue
                low = (planes[0][i], planes[1][j], planes[2][k])
                high = (planes[0][i + 1], planes[1][j + 1], planes[2][k + 1])
                for axis in range(3):
                    for side in (0, 1):
                        step = [0, 0, 0]
                        step[axis] = 2 * side - 1
                        if cell.get((i + step[0], j + step[1], k + step[2])) is None:
                            mesh.face(material, _side(low, high, axis, side))
    return mesh


def _side(low, high, axis, side):
    u, v = (axis + 1) % 3, (axis + 2) % 3
    corners = []
    for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
        p = [0, 0, 0]
        p[axis] = (low, high)[side][axis]
        p[u] = (low, high)[a][u]
        p[v] = (low, high)[b][v]
        corners.append(tuple(p))
    return corners if side else corners[::-1]


def prism(material, outline, z0, z1):
    """An upright prism from z0 to z1. The outline [(x, y), ...] is convex and counter-clockwise."""
    mesh = Mesh()
    n = len(outline)
    for i in range(n):
        (ax, ay), (bx, by) = outline[i], outline[(i + 1) % n]
        mesh.face(material, [(ax, ay, z0), (bx, by, z0), (bx, by, z1), (ax, ay, z1)])
    mesh.face(material, [(x, y, z1) for x, y in outline])
    mesh.face(material, [(x, y, z0) for x, y in reversed(outline)])
    return mesh


def circle(radius, sides, centre=(0, 0)):
    return [(centre[0] + radius * math.cos(2 * math.pi * i / sides),
             centre[1] + radius * math.sin(2 * math.pi * i / sides)) for i in range(sides)]


def curved_wall(material, centre, radius, thickness, from_deg, to_deg, pieces, z0, z1):
    """A wall along an arc, made of flat pieces. The radius is the inner one."""
    mesh = Mesh()
    angle = [math.radians(from_deg + (to_deg - from_deg) * i / pieces) for i in range(pieces + 1)]

    def at(r, i, z):
        return (centre[0] + r * math.cos(angle[i]), centre[1] + r * math.sin(angle[i]), z)

    outer, inner = radius + thickness, radius
    for i in range(pieces):
        j = i + 1
        mesh.face(material, [at(outer, i, z0), at(outer, j, z0), at(outer, j, z1), at(outer, i, z1)])
        mesh.face(material, [at(inner, j, z0), at(inner, i, z0), at(inner, i, z1), at(inner, j, z1)])
        mesh.face(material, [at(inner, i, z1), at(outer, i, z1), at(outer, j, z1), at(inner, j, z1)])
        mesh.face(material, [at(outer, i, z0), at(inner, i, z0), at(inner, j, z0), at(outer, j, z0)])
    for i, flip in ((0, False), (pieces, True)):
        end = [at(inner, i, z0), at(outer, i, z0), at(outer, i, z1), at(inner, i, z1)]
        mesh.face(material, end[::-1] if flip else end)
    return mesh


def write_materials(path, colors):
    with open(path, "w", newline="\n") as out:
        for name, (r, g, b) in colors.items():
            out.write(f"newmtl {name}\nKd {r:.3f} {g:.3f} {b:.3f}\n")


def write_obj(mesh, path, materials, title):
    with open(path, "w", newline="\n") as out:
        out.write(f"# {title}; made by maps/generate.py, metres, z up\nmtllib {materials}\n")
        for x, y, z in mesh.vertices:
            out.write(f"v {x:.6g} {y:.6g} {z:.6g}\n")
        last = None
        for material, numbers in sorted(mesh.faces, key=lambda f: f[0]):
            if material != last:
                out.write(f"usemtl {material}\n")
                last = material
            out.write("f " + " ".join(str(n + 1) for n in numbers) + "\n")


def write_dae(mesh, path, colors, title):
    """Writes COLLADA 1.4.1, with one triangle list per material."""
    used = sorted({material for material, _ in mesh.faces})
    lines = ['<?xml version="1.0" encoding="utf-8"?>',
             '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">',
             f'<asset><contributor><comments>{title}; made by maps/generate.py</comments>'
             '</contributor><created>2000-01-01T00:00:00</created><modified>2000-01-01T00:00:00'
             '</modified><unit name="metre" meter="1"/><up_axis>Z_UP</up_axis></asset>',
             '<library_effects>']
    for name in used:
        rgb = " ".join(f"{c:.3f}" for c in colors[name])
        lines.append(f'<effect id="{name}-effect"><profile_COMMON><technique sid="common"><lambert>'
                     f'<diffuse><color>{rgb} 1</color></diffuse></lambert></technique>'
                     '</profile_COMMON></effect>')
    lines.append('</library_effects><library_materials>')
    lines += [f'<material id="{n}" name="{n}"><instance_effect url="#{n}-effect"/></material>'
              for n in used]
    flat = " ".join(f"{c:.6g}" for v in mesh.vertices for c in v)
    count = len(mesh.vertices)
    lines += ['</library_materials><library_geometries><geometry id="mesh"><mesh>',
              f'<source id="positions"><float_array id="numbers" count="{3 * count}">{flat}'
              f'</float_array><technique_common><accessor source="#numbers" count="{count}" stride="3">'
              '<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" '
              'type="float"/></accessor></technique_common></source>',
              '<vertices id="vertices"><input semantic="POSITION" source="#positions"/></vertices>']
    for name in used:
        triangles = [(f[0], f[i], f[i + 1]) for m, f in mesh.faces if m == name
                     for i in range(1, len(f) - 1)]
        numbers = " ".join(str(n) for t in triangles for n in t)
        lines.append(f'<triangles material="{name}" count="{len(triangles)}"><input '
                     f'semantic="VERTEX" source="#vertices" offset="0"/><p>{numbers}</p></triangles>')
    bind = "".join(f'<instance_material symbol="{n}" target="#{n}"/>' for n in used)
    lines += ['</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="scene">',
              '<node id="node"><instance_geometry url="#mesh"><bind_material><technique_common>'
              f'{bind}</technique_common></bind_material></instance_geometry></node>',
              '</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#scene"/>'
              '</scene></COLLADA>']
    with open(path, "w", newline="\n") as out:
        out.write("\n".join(lines) + "\n")
