"""Collects the objects of the training images: furniture catalogues of Debian, and variants made here.

    objects.py OUT_DIR

Writes OBJ files and index.txt. The index has one object per line, separated by tabs, in metres:
    class  split  width  depth  height  elevation  rotation  file
rotation has nine numbers (by rows) that turn the axes of the file; afterwards y up becomes z up. It is
`-` for files with z up. About a quarter of the movable objects belongs to the test split and is never
used in training. The split of an object follows from its name alone.
"""
import hashlib
import os
import random
import re
import sys
import zipfile

TRAINING = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(TRAINING, "..", "..", "maps"))
from solid import Mesh, boxes, circle, prism, write_materials, write_obj  # noqa: E402

CATALOGUES = "/usr/share/sweethome3d/furniture"
LARGEST_FILE = 1_600_000  # bytes of an OBJ file; larger files give no better images at 320x240

# Class by catalogue name. The first match counts. An object without a match is background.
CLASS_BY_NAME = [
    ("background", r"screen door|japanese|tv stand|television|intercom|cctv|remote|deck chair|"
                   r"beach chair|pool|bathroom|child swing|chair-ottoman"),
    ("person", r"female|male$|boy|girl|mannequin"),
    ("sofa", r"sofa|couch|armchair|futon couch|relax chair"),
    ("chair", r"chair|stool|class seat"),
    ("computer", r"imac|laptop|ibook"),
    ("screen", r"^tv|wall flat tv"),
]
# Left out of the background: objects that are no furniture of a room, and flat objects.
LEFT_OUT = (r"pool|swim|parking|crossing|road|rail|garage|car\b|sedan|truck|bus\b|van$|suv|scenic|"
            r"peugeot|smart|leon|chevrolet|focus|beetle|biplane|boat|container|tree|maple|pine|"
            r"poplar|cypress|acacia|beech|coconut|hedge|palm|hut|tent|street|football|jacuzzi|"
            r"fence|bill |socket|plug|switch|ring|grass|sandpit|escalator|elevator|barnum")
INDOORS = {"Bedroom", "Living room", "Office", "Kitchen", "Bathroom", "Miscellaneous", "Lights",
           "Characters"}


def split_of(name):
    """Returns "test" for about a quarter of all names, otherwise "train"."""
    return "test" if hashlib.sha256(name.encode()).digest()[0] % 4 == 0 else "train"


def read_catalogue(text):
    """Reads the properties file of a catalogue. Returns a dict for every object, in the file's order."""
    entries = {}
    for line in text.splitlines():
        match = re.match(r"(\w+)#(\d+)=(.*)", line.strip())
        if match:
            entries.setdefault(int(match[2]), {})[match[1]] = match[3]
    return [entries[k] for k in sorted(entries)]


def class_of(entry):
    """Returns the class of a catalogue entry by its name and the name of its model file."""
    text = entry["name"].lower()
    for name, pattern in CLASS_BY_NAME:
        if re.search(pattern, text) or re.search(pattern, entry["model"].lower()):
            return name
    return "background"


def extract_catalogues(out):
    """Extracts the catalogue objects into the folder `out`. Yields the index entry of every object."""
    for file in sorted(os.listdir(CATALOGUES)):
        if not file.endswith(".sh3f"):
            continue
        library = file[:-5]
        with zipfile.ZipFile(os.path.join(CATALOGUES, file)) as archive:
            sizes = {i.filename: i.file_size for i in archive.infolist()}
            text = archive.read("PluginFurnitureCatalog.properties").decode("latin1")
            for entry in read_catalogue(text):
                model = entry["model"].lstrip("/")
                name = class_of(entry)
                if entry.get("category") not in INDOORS or entry.get("doorOrWindow") == "true":
                    continue
                if name == "background" and re.search(LEFT_OUT, entry["name"].lower()):
                    continue
                size = [float(entry[k]) / 100 for k in ("width", "depth", "height")]
                if sizes.get(model, 10**9) > LARGEST_FILE or max(size) < 0.12 or max(size) > 3.6:
                    continue
                for member in sizes:
                    if os.path.dirname(member) == os.path.dirname(model) and member.lower().endswith(
                            (".obj", ".mtl")):
                        archive.extract(member, os.path.join(out, library))
                rotation = entry.get("modelRotation") or "1 0 0 0 1 0 0 0 1"
                yield (name, split_of(library + model), *size,
                       float(entry.get("elevation") or 0) / 100, rotation,
                       os.path.join(library, model))


def random_chair(r):
    w, d, seat, back = r.uniform(.19, .26), r.uniform(.18, .26), r.uniform(.40, .50), r.uniform(.75, 1.1)
    t, leg = r.uniform(.03, .10), r.uniform(.02, .05)
    parts = [("a", (-w, -d, seat - t), (w, d, seat))]
    style = r.choice(["slab", "frame", "gap"])
    if style == "slab":
        parts.append(("a", (-w, d - t, seat), (w, d, back)))
    else:
        for x in (-w, w - leg):
            parts.append(("b", (x, d - leg, seat), (x + leg, d, back)))
        low = back - r.uniform(.1, .3) if style == "gap" else seat + .1
        parts.append(("a", (-w, d - leg, low), (w, d, back)))
    if r.random() < .3:  # arms
        for x in (-w, w - leg):
            parts.append(("b", (x, -d + .05, seat + .18), (x + leg, d - t, seat + .22)))
            parts.append(("b", (x, -d + .05, seat), (x + leg, -d + .05 + leg, seat + .18)))
    if r.random() < .7:
        for x in (-w, w - leg):
            for y in (-d, d - leg):
                parts.append(("b", (x, y, 0), (x + leg, y + leg, seat - t)))
        return boxes(*parts)
    mesh = boxes(*parts)  # office chair with a column and a five-armed base
    mesh.add(prism("b", circle(.03, 8), .08, seat - t))
    for i in range(5):
        mesh.add(boxes(("b", (0, -.02, .05), (.30, .02, .09))), (0, 0, 0), 72 * i)
    return mesh


def random_sofa(r):
    w, d = r.uniform(.35, 1.25), r.uniform(.36, .52)
    low, seat, back = r.choice([0, r.uniform(.05, .14)]), r.uniform(.36, .48), r.uniform(.68, 1.0)
    arm, thick, armtop = r.uniform(.10, .25), r.uniform(.14, .28), r.uniform(.52, .7)
    parts = [("a", (-w, -d, low), (w, d, seat)), ("a", (-w, d - thick, seat), (w, d, back))]
    if r.random() < .85:
        parts += [("a", (-w, -d, seat), (-w + arm, d - thick, armtop)),
                  ("a", (w - arm, -d, seat), (w, d - thick, armtop))]
    mesh = boxes(*parts)
    if r.random() < .6:  # cushions
        n = max(1, round(2 * (w - arm) / .65))
        step = 2 * (w - arm) / n
        for i in range(n):
            x = -w + arm + i * step
            mesh.add(boxes(("c", (x + .01, -d - .02, seat - .005), (x + step - .01, d - thick, seat + .10))))
            mesh.add(boxes(("c", (x + .01, d - thick - .12, seat + .10), (x + step - .01, d - thick, back - .04))))
    if low > 0:
        for x in (-w + .05, w - .1):
            for y in (-d + .05, d - .1):
                mesh.add(boxes(("b", (x, y, 0), (x + .05, y + .05, low))))
    return mesh


def random_computer(r):
    w, d, h = r.uniform(.08, .12), r.uniform(.18, .27), r.uniform(.32, .52)
    if r.random() < .15:
        w, d, h = r.uniform(.18, .22), r.uniform(.18, .22), r.uniform(.10, .15)  # a lying computer
    f = -d - .008
    mesh = boxes(("a", (-w, -d, .015), (w, d, h)))
    for y in (-d + .02, d - .05):
        mesh.add(boxes(("b", (-w + .01, y, 0), (w - .01, y + .03, .015))))
    z = h - .03
    for _ in range(r.randint(1, 4)):  # drive bays
        high = r.choice([.03, .042])
        if z - high < .08:
            break
        mesh.add(boxes((r.choice("abc"), (-w + .02, f, z - high), (w - .02, -d, z - .004))))
        z -= high + .005
    if r.random() < .6:
        mesh.add(boxes(("c", (-w * .5, f, z - .04), (-w * .5 + .025, -d, z - .015))))  # button
    for i in range(r.randint(0, 6)):
        mesh.add(boxes(("b", (-w + .03, f, .05 + .02 * i), (w - .03, -d, .06 + .02 * i))))  # vents
    if r.random() < .5:
        mesh.add(boxes(("c", (-w - .006, -d + .05, .06), (-w, d - .05, h - .05))))  # side panel
    return mesh


def random_screen(r):
    w = r.uniform(.2, .62)
    h = 2 * w * r.choice([.56, .56, .63, .75])
    t, bezel = r.uniform(.015, .05), r.uniform(.01, .03)
    foot = r.uniform(.04, .15)
    mesh = boxes(("b", (-w, 0, foot), (w, t, foot + h)),
                 (None, (-w + bezel, 0, foot + bezel), (w - bezel, .004, foot + h - bezel)),
                 ("a", (-w + bezel, .004, foot + bezel), (w - bezel, .008, foot + h - bezel)))
    mesh.add(boxes(("b", (-.04, t, .01), (.04, t + .02, foot + .5 * h))))
    base = r.uniform(.3, .7) * w
    mesh.add(boxes(("b", (-base, -.08, 0), (base, .10, .012))))
    if r.random() < .12:  # an old, deep screen
        mesh.add(boxes(("b", (-.7 * w, t, foot + .1 * h), (.7 * w, t + r.uniform(.2, .35), foot + .9 * h))))
    return mesh


def random_person(r):
    body, k = Mesh(), r.uniform(.88, 1.06)
    sides = r.choice([8, 12, 20])
    leg, hip, shoulder = r.uniform(.06, .10), r.uniform(.08, .12), r.uniform(1.35, 1.48)
    waist = r.uniform(.78, .9)
    for x in (-hip, hip):
        step = r.uniform(-.12, .12)
        body.add(prism("b", circle(leg, sides), 0, waist * k), (x, step, 0))
        body.add(boxes(("e", (x - .05, step - .18, 0), (x + .05, step + .08, .08))))
    chest = r.uniform(.13, .2)
    outline = [(1.25 * x, y) for x, y in circle(chest, sides)] if r.random() < .6 else circle(chest, sides)
    body.add(prism("c", outline, waist * k, shoulder * k))
    for x in (-1.25 * chest - .05, 1.25 * chest + .05):
        arm = r.uniform(.04, .06)
        low = r.uniform(.72, .85)
        forward = r.random() < .3
        body.add(prism("c", circle(arm, 8), (1.1 if forward else low) * k, (shoulder - .02) * k), (x, 0, 0))
        if forward:
            body.add(boxes(("d", (x - arm, -.4, 1.1 * k), (x + arm, 0, 1.1 * k + 2 * arm))))
    body.add(prism("d", circle(.055, 10), shoulder * k, (shoulder + .08) * k))
    head = r.uniform(.085, .115)
    top = (shoulder + .08 + r.uniform(.2, .28)) * k
    body.add(prism("d", circle(head, sides), (shoulder + .08) * k, top))
    if r.random() < .7:
        body.add(prism("e", circle(head * 1.06, sides), top - .09, top + .02))
    return body


MAKERS = {"chair": random_chair, "sofa": random_sofa, "computer": random_computer,
          "screen": random_screen, "person": random_person}


def make_variants(out, count=48):
    """Makes `count` random objects of every class in MAKERS. Yields the index entry of every object."""
    folder = os.path.join(out, "made")
    os.makedirs(folder, exist_ok=True)
    write_materials(os.path.join(folder, "made.mtl"),
                    {"a": (.5, .3, .3), "b": (.25, .25, .27), "c": (.4, .45, .6), "d": (.8, .62, .5),
                     "e": (.15, .12, .1)})
    for name, maker in MAKERS.items():
        for i in range(count):
            mesh = maker(random.Random(f"{name} {i}"))
            file = f"made/{name}_{i}.obj"
            write_obj(mesh, os.path.join(out, file), "made.mtl", name)
            size = [max(v[a] for v in mesh.vertices) - min(v[a] for v in mesh.vertices)
                    for a in range(3)]
            yield (name, split_of(file), *size, 0.0, "-", file)


def main():
    out = sys.argv[1]
    os.makedirs(out, exist_ok=True)
    if not os.path.isdir(CATALOGUES):
        raise SystemExit(f"{CATALOGUES} is missing: apt-get install sweethome3d-furniture")
    rows = list(extract_catalogues(out)) + list(make_variants(out))
    with open(os.path.join(out, "index.txt"), "w", newline="\n") as index:
        for name, split, width, depth, height, elevation, rotation, file in rows:
            # Both splits use the same background objects, which the network must not find.
            split = "both" if name == "background" else split
            index.write(f"{name}\t{split}\t{width:.4f}\t{depth:.4f}\t{height:.4f}\t{elevation:.3f}\t"
                        f"{rotation}\t{file}\n")
    print(f"{len(rows)} objects in {out}")


if __name__ == "__main__":
    main()
