#!/usr/bin/env python3
"""Writes all models of this folder: generate.py [FOLDER]. Every run writes the same bytes."""
import os
import sys

from solid import (Mesh, boxes, circle, curved_wall, prism, write_dae, write_materials, write_obj)

COLORS = {
    "wall": (0.84, 0.82, 0.76), "partition": (0.74, 0.78, 0.80), "floor": (0.42, 0.36, 0.30),
    "ceiling": (0.92, 0.92, 0.90), "carpet": (0.30, 0.36, 0.44), "wood": (0.58, 0.42, 0.26),
    "dark_wood": (0.36, 0.25, 0.16), "white": (0.93, 0.93, 0.93), "metal": (0.52, 0.54, 0.57),
    "black": (0.10, 0.10, 0.11), "glass": (0.62, 0.74, 0.82), "blue": (0.22, 0.34, 0.58),
    "red": (0.62, 0.20, 0.18), "green": (0.24, 0.44, 0.28), "stone": (0.66, 0.63, 0.58),
    "skin": (0.80, 0.62, 0.50), "trousers": (0.20, 0.22, 0.30), "shirt": (0.60, 0.28, 0.24),
}


def table(width, depth, height=0.74, top="wood", legs="metal"):
    t, leg = 0.04, 0.06
    parts = [(top, (0, 0, height - t), (width, depth, height))]
    for x in (0.03, width - 0.03 - leg):
        for y in (0.03, depth - 0.03 - leg):
            parts.append((legs, (x, y, 0), (x + leg, y + leg, height - t)))
    return boxes(*parts)


def shelf(width, depth, height, boards, material="wood"):
    t = 0.03
    parts = [(material, (0, 0, 0), (width, depth, height)),
             (None, (t, t, t), (width - t, depth, height - t))]
    for i in range(1, boards):
        z = height * i / boards
        parts.append((material, (t, t, z), (width - t, depth, z + t)))
    return boxes(*parts)


def cupboard(width, depth, height, material="dark_wood"):
    return boxes((material, (0, 0, 0), (width, depth, height)),
                 (None, (width / 2 - 0.01, depth - 0.02, 0.1), (width / 2 + 0.01, depth, height - 0.05)),
                 ("metal", (width / 2 - 0.08, depth, 1.0), (width / 2 - 0.05, depth + 0.03, 1.15)),
                 ("metal", (width / 2 + 0.05, depth, 1.0), (width / 2 + 0.08, depth + 0.03, 1.15)))


def screen():
    return boxes(("black", (-0.28, -0.02, 0.12), (0.28, 0.02, 0.46)),
                 ("black", (-0.03, -0.02, 0.02), (0.03, 0.02, 0.12)),
                 ("black", (-0.12, -0.09, 0), (0.12, 0.09, 0.02)))


def chair():
    parts = [("blue", (-0.22, -0.22, 0.42), (0.22, 0.22, 0.48)),
             ("blue", (-0.22, 0.18, 0.48), (0.22, 0.22, 0.92))]
    for x in (-0.21, 0.17):
        for y in (-0.21, 0.17):
            parts.append(("metal", (x, y, 0), (x + 0.04, y + 0.04, 0.42)))
    return boxes(*parts)


def sofa():
    return boxes(("red", (-0.95, -0.42, 0.08), (0.95, 0.42, 0.42)),
                 ("red", (-0.95, 0.22, 0.42), (0.95, 0.42, 0.85)),
                 ("red", (-0.95, -0.42, 0.42), (-0.77, 0.22, 0.62)),
                 ("red", (0.77, -0.42, 0.42), (0.95, 0.22, 0.62)))


def pc_case():
    return boxes(("black", (-0.10, -0.22, 0), (0.10, 0.22, 0.44)),
                 ("metal", (-0.08, -0.23, 0.30), (0.08, -0.22, 0.40)))


def person():
    body = Mesh()
    for x in (-0.10, 0.10):
        body.add(prism("trousers", circle(0.08, 12), 0, 0.85), (x, 0, 0))
    body.add(prism("shirt", circle(0.19, 16), 0.85, 1.45))
    for x in (-0.25, 0.25):
        body.add(prism("shirt", circle(0.05, 10), 0.80, 1.42), (x, 0, 0))
    body.add(prism("skin", circle(0.06, 10), 1.45, 1.53))
    body.add(prism("skin", circle(0.10, 14), 1.53, 1.78))
    return body


def window(axis, at, along, width, z0, z1, inward, t=0.12):
    """Cuts an opening into a wall of thickness t and sets a pane and a cross of bars into it."""
    def box(material, a0, a1, b0, b1, c0, c1):
        low, high = (a0, b0), (a1, b1)
        if axis == "x":
            return (material, (low[0], low[1], c0), (high[0], high[1], c1))
        return (material, (low[1], low[0], c0), (high[1], high[0], c1))
    outer, inner = (at, at + t) if inward > 0 else (at - t, at)
    pane0 = outer + 0.03 if inward > 0 else inner - 0.05
    middle, bar = along + width / 2, 0.025
    return [box(None, outer, inner, along, along + width, z0, z1),
            box("glass", pane0, pane0 + 0.02, along, along + width, z0, z1),
            box("white", pane0 - 0.01, pane0 + 0.03, middle - bar, middle + bar, z0, z1),
            box("white", pane0 - 0.01, pane0 + 0.03, along, along + width,
                (z0 + z1) / 2 - bar, (z0 + z1) / 2 + bar)]


def office():
    """Two furnished rooms, 10 x 6 x 2.8 m, with a doorway between them."""
    w, d, h, t = 10.0, 6.0, 2.8, 0.12
    shell = [("wall", (-t, -t, -t), (w + t, d + t, h + t)), (None, (0, 0, 0), (w, d, h)),
             ("floor", (0, 0, -t), (w, d, 0)), ("ceiling", (0, 0, h), (w, d, h + t)),
             ("partition", (5.94, 0, 0), (6.06, d, h)), (None, (5.94, 2.4, 0), (6.06, 3.4, 2.1)),
             ("carpet", (1.2, 1.6, 0), (4.4, 4.2, 0.012)),
             ("white", (0, 0, 0), (0.9, 0.015, 0.08)), ("white", (1.9, 0, 0), (5.94, 0.015, 0.08)),
             ("white", (0, d - 0.015, 0), (5.94, d, 0.08)),
             ("white", (6.06, d - 0.015, 0), (w, d, 0.08)),
             ("dark_wood", (0.9, 0, 0), (1.9, 0.03, 2.05)),
             ("white", (0.82, 0, 0), (0.9, 0.05, 2.13)), ("white", (1.9, 0, 0), (1.98, 0.05, 2.13)),
             ("white", (0.9, 0, 2.05), (1.9, 0.05, 2.13)),
             ("white", (5.90, 2.32, 0), (6.10, 2.4, 2.18)),
             ("white", (5.90, 3.4, 0), (6.10, 3.48, 2.18)),
             ("white", (5.90, 2.4, 2.1), (6.10, 3.4, 2.18)),
             ("white", (2.2, d - 0.04, 1.0), (4.6, d, 2.1)),
             ("metal", (2.4, d - 0.12, 0.97), (4.4, d - 0.04, 1.0)),
             ("metal", (1.5, 1.6, h - 0.10), (1.7, 4.4, h)), ("metal", (4.0, 1.6, h - 0.10), (4.2, 4.4, h)),
             ("metal", (7.9, 1.6, h - 0.10), (8.1, 4.4, h)),
             ("wall", (5.3, d - 0.45, 0), (5.94, d, h))]
    for y in (0.9, 3.3):
        shell += window("x", 0, y, 1.7, 0.9, 2.2, -1)
        shell.append(("metal", (0.03, y + 0.1, 0.15), (0.12, y + 1.6, 0.75)))
    shell += window("y", d, 7.2, 1.8, 0.9, 2.2, 1)
    mesh = boxes(*shell)
    mesh.add(table(1.6, 0.8), (2.6, 2.0, 0.012)).add(table(1.6, 0.8), (2.6, 3.0, 0.012))
    mesh.add(screen(), (3.1, 2.55, 0.752)).add(screen(), (3.7, 3.25, 0.752), 180)
    mesh.add(cupboard(1.2, 0.45, 1.95), (4.4, 0.05, 0)).add(shelf(1.6, 0.35, 2.0, 5), (2.2, 0.05, 0))
    mesh.add(table(0.8, 0.8, 0.72, "white"), (0.5, 4.9, 0))
    mesh.add(shelf(1.8, 0.35, 1.2, 3, "white"), (9.9, 0.6, 0), 90)
    mesh.add(table(2.2, 1.1, 0.74, "dark_wood"), (7.0, 2.3, 0))
    mesh.add(cupboard(1.0, 0.5, 1.4, "green"), (9.95, 3.6, 0), 90)
    mesh.add(shelf(1.2, 0.3, 2.2, 6), (6.5, 0.05, 0))
    return mesh


def house():
    """Two storeys of 8 x 6 m with a stair between them."""
    w, d, h, t = 8.0, 6.0, 2.6, 0.15
    top = h + 0.2
    shell = [("wall", (-t, -t, -t), (w + t, d + t, top + h + t)),
             (None, (0, 0, 0), (w, d, h)), (None, (0, 0, top), (w, d, top + h)),
             ("floor", (0, 0, -t), (w, d, 0)), ("wood", (0, 0, h), (w, d, top)),
             ("ceiling", (0, 0, h), (w, d, h + 0.02)),
             ("ceiling", (0, 0, top + h), (w, d, top + h + t)),
             (None, (4.2, 4.7, h), (w, d, top)),
             ("partition", (4.0, 0, 0), (4.12, 3.6, h)), (None, (4.0, 1.3, 0), (4.12, 2.3, 2.05)),
             ("partition", (0, 3.0, top), (3.6, 3.12, top + h)),
             (None, (1.3, 3.0, top), (2.3, 3.12, top + 2.05)),
             ("metal", (4.14, 4.62, top), (8.0, 4.66, top + 0.9)),
             (None, (4.24, 4.62, top + 0.1), (7.9, 4.66, top + 0.82)),
             ("white", (1.22, 2.96, top), (1.3, 3.16, top + 2.13)),
             ("white", (2.3, 2.96, top), (2.38, 3.16, top + 2.13)),
             ("white", (1.3, 2.96, top + 2.05), (2.3, 3.16, top + 2.13)),
             ("white", (3.96, 1.22, 0), (4.16, 1.3, 2.13)), ("white", (3.96, 2.3, 0), (4.16, 2.38, 2.13)),
             ("white", (3.96, 1.3, 2.05), (4.16, 2.3, 2.13)),
             ("stone", (0.0, 1.0, 0), (0.3, 2.0, 0.9)), (None, (0.0, 1.2, 0.1), (0.3, 1.8, 0.6)),
             ("stone", (0.0, 1.1, 0.9), (0.25, 1.9, h))]
    steps = 14
    for i in range(steps):
        x = 7.7 - 0.25 * i
        shell.append(("dark_wood", (x - 0.25, 5.0, 0), (x, 5.95, top * (i + 1) / steps)))
    for z in (0, top):
        shell += window("x", 0, 3.9, 1.4, z + 0.9, z + 2.1, -1, t)
        shell += window("x", w, 1.2, 1.6, z + 0.9, z + 2.1, 1, t)
        shell += window("y", 0, 5.2, 1.5, z + 0.9, z + 2.1, -1, t)
    mesh = boxes(*shell)
    mesh.add(table(1.8, 0.9, 0.74, "dark_wood"), (1.4, 1.6, 0))
    mesh.add(cupboard(1.6, 0.5, 2.0), (2.2, 5.95, 0), 180)
    mesh.add(boxes(("white", (0, 0, 0), (2.4, 0.6, 0.88)), ("stone", (0, 0, 0.88), (2.4, 0.62, 0.92)),
                   ("metal", (1.4, 0.08, 0.92), (2.0, 0.54, 0.93))), (4.5, 0.05, 0))
    mesh.add(table(1.0, 1.0, 0.74), (5.6, 2.4, 0)).add(shelf(1.2, 0.35, 1.8, 4), (4.5, 3.95, 0), -90)
    bed = boxes(("dark_wood", (0, 0, 0.1), (1.6, 2.0, 0.35)), ("white", (0.05, 0.05, 0.35), (1.55, 1.95, 0.5)),
                ("dark_wood", (0, -0.08, 0.1), (1.6, 0, 1.0)), ("blue", (0.1, 0.1, 0.5), (0.7, 0.5, 0.6)))
    mesh.add(bed, (5.2, 0.4, top)).add(bed, (0.3, 0.3, top))
    mesh.add(cupboard(1.5, 0.55, 2.1, "white"), (3.5, 5.95, top), 180).add(table(1.2, 0.6), (0.3, 4.2, top))
    mesh.add(shelf(1.0, 0.3, 1.9, 5), (3.55, 0.9, top), 90)
    return mesh


def hall():
    """A hall of 20 x 12 x 5 m with round columns, a curved wall and a platform."""
    w, d, h, t = 20.0, 12.0, 5.0, 0.2
    shell = [("wall", (-t, -t, -t), (w + t, d + t, h + t)), (None, (0, 0, 0), (w, d, h)),
             ("stone", (0, 0, -t), (w, d, 0)), ("ceiling", (0, 0, h), (w, d, h + t)),
             ("wood", (15.5, 2.0, 0), (20.0, 10.0, 0.6)), ("wood", (15.1, 4.5, 0), (15.5, 7.5, 0.3)),
             ("dark_wood", (0, 5.0, 0), (0.06, 7.0, 2.4)),
             ("white", (0, 4.9, 0), (0.1, 5.0, 2.5)), ("white", (0, 7.0, 0), (0.1, 7.1, 2.5)),
             ("white", (0, 5.0, 2.4), (0.1, 7.0, 2.5))]
    for i in range(5):
        x = 1.5 + 3.6 * i
        shell += window("y", 0, x, 2.2, 1.6, 4.0, -1, t)
        shell.append(("metal", (x + 1.0, 1.0, h - 0.15), (x + 1.2, 11.0, h)))
    mesh = boxes(*shell)
    for x in (4.0, 8.0, 12.0):
        for y in (3.4, 8.6):
            mesh.add(prism("stone", circle(0.45, 32), 0, 0.25), (x, y, 0))
            mesh.add(prism("white", circle(0.32, 32), 0.25, 4.7), (x, y, 0))
            mesh.add(prism("stone", circle(0.45, 32), 4.7, h), (x, y, 0))
    mesh.add(curved_wall("partition", (10.0, 6.0), 5.2, 0.2, 60, 120, 24, 0, 3.2))
    for x in (2.0, 6.0, 10.0):
        mesh.add(boxes(("dark_wood", (0, 0, 0.4), (2.0, 0.45, 0.46)), ("metal", (0.2, 0.1, 0), (0.3, 0.35, 0.4)),
                       ("metal", (1.7, 0.1, 0), (1.8, 0.35, 0.4))), (x, 1.2, 0))
    mesh.add(table(1.2, 0.6, 1.1, "dark_wood", "dark_wood"), (17.0, 5.7, 0.6))
    mesh.add(cupboard(2.0, 0.5, 2.2, "green"), (2.2, 11.9, 0), 180)
    mesh.add(shelf(2.0, 0.4, 2.4, 5), (14.5, 11.9, 0), 180)
    return mesh


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    os.makedirs(os.path.join(folder, "objects"), exist_ok=True)
    write_materials(os.path.join(folder, "materials.mtl"), COLORS)
    write_materials(os.path.join(folder, "objects", "materials.mtl"), COLORS)
    for name, make in (("office", office), ("house", house), ("hall", hall)):
        write_obj(make(), os.path.join(folder, name + ".obj"), "materials.mtl", make.__doc__)
    write_dae(office(), os.path.join(folder, "office.dae"), COLORS, office.__doc__)
    for name, make in (("chair", chair), ("sofa", sofa), ("pc_case", pc_case), ("person", person)):
        write_obj(make(), os.path.join(folder, "objects", name + ".obj"), "materials.mtl", name)


if __name__ == "__main__":
    main()
