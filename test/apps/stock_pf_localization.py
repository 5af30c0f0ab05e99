#!/usr/bin/python3
"""The unmodified pf-localization of MRPT, with the map of this project, must end near the truth.

usage: stock_pf_localization.py EDGE_MCL PLUGIN_LIBRARY INI_TEMPLATE SEQUENCE

Exit code 77 (skipped) when pf-localization or the sequence is missing.
"""
import glob
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

FORWARD = ((0, 0, 1), (-1, 0, 0), (0, -1, 0))  # axes of the optical frame on a body with x forward, z up


def rotation(q):
    x, y, z, w = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]


def body_angles(q):
    """Yaw, pitch, roll (degrees) of the body that carries a camera with orientation q."""
    r = rotation(q)
    b = [[sum(r[i][k] * FORWARD[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    return (math.degrees(math.atan2(b[1][0], b[0][0])), math.degrees(math.asin(-b[2][0])),
            math.degrees(math.atan2(b[2][1], b[2][2])))


def numbers(file):
    with open(file) as f:
        return [[float(x) for x in l.split()] for l in f if l.strip() and l[0] not in '#%']


def main():
    tool, plugin, template, sequence = sys.argv[1:5]
    if not shutil.which('pf-localization') or not os.path.isdir(sequence):
        print('SKIPPED: pf-localization or %s is missing' % sequence)
        return 77
    with tempfile.TemporaryDirectory() as folder:
        rawlog = os.path.join(folder, 'sequence.rawlog')
        subprocess.run([tool, 'rawlog', sequence, rawlog], check=True)
        with open(os.path.join(sequence, 'sequence.yaml')) as f:
            start = [float(x) for x in
                     re.search(r'initial_pose: \[([^\]]*)\]', f.read()).group(1).split(',')]
        angles = body_angles(start[3:])
        values = {'MODEL': os.path.join(sequence, 'model.obj'), 'OUT': os.path.join(folder, 'log')}
        for name, v, spread in list(zip('XYZ', start, (0.15,) * 3)) + list(
                zip(('YAW', 'PITCH', 'ROLL'), angles, (4,) * 3)):
            values['MIN_' + name], values['MAX_' + name] = v - spread, v + spread
        with open(template) as f:
            text = re.sub('@([A-Z_]+)@', lambda m: str(values[m.group(1)]), f.read())
        ini = os.path.join(folder, 'pf.ini')
        with open(ini, 'w') as f:
            f.write(text)
        run = subprocess.run(['pf-localization', ini, rawlog], capture_output=True, text=True,
                             env=dict(os.environ, LD_PRELOAD=plugin), timeout=900)
        # There is one folder for each experiment and number of particles.
        logs = glob.glob(os.path.join(folder, 'log_*', 'particles'))
        particles = logs[0] if logs else folder
        if run.returncode != 0 or not logs:
            print(run.stdout[-3000:], run.stderr[-3000:])
            return 1
        if os.environ.get('EDGE_MCL_TEST_VERBOSE'):
            print(run.stdout[-6000:], run.stderr[-3000:], os.listdir(particles))
        last = sorted(x for x in os.listdir(particles) if re.fullmatch(r'particles_\d+\.txt', x))[-1]
        rows = numbers(os.path.join(particles, last))
        top = max(r[6] for r in rows)
        weights = [math.exp(r[6] - top) for r in rows]
        mean = [sum(w * r[i] for w, r in zip(weights, rows)) / sum(weights) for i in range(3)]
        truth = numbers(os.path.join(sequence, 'groundtruth.txt'))[-1][1:]
        distance = math.dist(mean, truth[:3])
        # The angles are at most a few degrees apart. So their means about the truth are taken one by one.
        turn = []
        for i, t in enumerate(body_angles(truth[3:])):
            d = [math.remainder(math.degrees(r[3 + i]) - t, 360) for r in rows]
            turn.append(sum(w * x for w, x in zip(weights, d)) / sum(weights))
        angle = math.sqrt(sum(x * x for x in turn))
        print('%s of %d particles: %.1f cm and %.2f deg from the truth' % (
            last, len(rows), 100 * distance, angle))
        return 0 if distance < 0.10 and angle < 3 else 1


if __name__ == '__main__':
    sys.exit(main())
