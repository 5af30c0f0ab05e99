#!/usr/bin/python3
"""`edge-mcl align`: a model that was turned, shifted and scaled is brought back by one flight. The truth is the change.

usage: align.py EDGE_MCL SOURCE_DIRECTORY
"""
import json
import math
import os
import sys
import tempfile

import numpy as np

sys.dont_write_bytecode = True  # no .pyc of command_line.py in the source directory
from command_line import INCOMPLETE, INPUT, OK, USAGE, Cases, check, failures, write

SCENARIO = '''model: %(maps)s/office.obj
camera: %(source)s/test/data/small_camera.yaml
rate: 15
path:
  - {time: 0, position: [1.0, 1.2, 1.3], yaw_deg: 35}
  - {time: 1.5, position: [1.6, 1.6, 1.4], yaw_deg: 55}
  - {time: 3, position: [2.4, 1.7, 1.4], yaw_deg: 75}
  - {time: 5, position: [3.4, 2.6, 1.5], yaw_deg: 120}
'''
YAW, SHIFT, SCALE = 137.0, np.array([40.0, -7.0, 1.5]), 0.0254


def turned(yaw_deg):
    a = math.radians(yaw_deg)
    return np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])


def rotation_of(result):
    """Yaw, then pitch, then roll, as map.* has them."""
    yaw, pitch, roll = (math.radians(result[name + '_deg']) for name in ('yaw', 'pitch', 'roll'))
    about_y = np.array([[math.cos(pitch), 0, math.sin(pitch)], [0, 1, 0], [-math.sin(pitch), 0, math.cos(pitch)]])
    about_x = np.array([[1, 0, 0], [0, math.cos(roll), -math.sin(roll)], [0, math.sin(roll), math.cos(roll)]])
    return turned(math.degrees(yaw)) @ about_y @ about_x


def changed_model(source, target):
    """Writes the model in inches, turned and shifted, so that file = (turn * original + shift) / SCALE."""
    with open(source) as lines, open(target, 'w') as out:
        for line in lines:
            if line.startswith('v '):
                point = turned(YAW) @ np.array(line.split()[1:4], float) + SHIFT
                out.write('v %.6f %.6f %.6f\n' % tuple(point / SCALE))
            else:
                out.write(line)


def errors(result):
    """Largest error of the corners of the office, and of the angles."""
    rotation = rotation_of(result)
    farthest = 0
    for corner in ([0, 0, 0], [8, 0, 0], [8, 6, 2.6], [0, 6, 2.6]):
        corner = np.array(corner, float)
        in_file = (turned(YAW) @ corner + SHIFT) / SCALE
        back = result['scale'] * (rotation @ in_file) + np.array(result['position'])
        farthest = max(farthest, np.linalg.norm(back - corner))
    tilt = max(abs(result['pitch_deg']), abs(result['roll_deg']))
    yaw = abs((result['yaw_deg'] + YAW + 180) % 360 - 180)
    return farthest, max(tilt, yaw)


def main():
    tool, source = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        c = Cases(tool, folder)
        scenario, flight = os.path.join(folder, 'flight.yaml'), os.path.join(folder, 'flight')
        write(scenario, SCENARIO % {'maps': os.path.join(source, 'maps'), 'source': source})
        r = c.run('simulate', scenario, flight)
        check(r.returncode == OK, r.stderr)
        model, out = os.path.join(folder, 'inches.obj'), os.path.join(folder, 'map.yaml')
        changed_model(os.path.join(source, 'maps', 'office.obj'), model)
        truth = os.path.join(flight, 'groundtruth.txt')
        r = c.run('align', flight, '--model', model, '--poses', truth, '--out', out, '--json')
        check(r.returncode == OK, 'align: %d %s' % (r.returncode, r.stderr[-800:]))
        result = json.loads(r.stdout)
        position, angle = errors(result)
        # A tilt of 0.05 degrees moves the far corner by 0.7 cm. The unit is known exactly, since it is a usual one.
        check(position < 0.01 and angle < 0.1, 'corners within %.4f m, angles within %.3f degrees' % (position, angle))
        check(abs(result['scale'] / SCALE - 1) < 0.002, 'scale %.6f' % result['scale'])
        check(result['sigma']['position_m'] < 0.02 and result['sigma']['angle_deg'] < 0.2, 'sigma %s' % result['sigma'])

        # The written parameters place the model in the coordinates of the truth.
        r = c.run('localize', flight, '--model', model, '--params', out, '--json', '--out', os.path.join(folder, 'est.txt'))
        summary = json.loads(r.stdout) if r.returncode == OK else {}
        error = summary.get('position_error_median_m', 1e9)
        check(error < 0.02, 'localized with the parameters: %.4f m %s' % (error, r.stderr[-300:]))

        # The same by four corners, read to the millimetre.
        pairs = os.path.join(folder, 'pairs.txt')
        corners = [np.array(p, float) for p in ([0, 0, 0], [8, 0, 0], [8, 6, 0], [0, 6, 2.6])]
        lines = ['%.4f %.4f %.4f  %.3f %.3f %.3f' % (*((turned(YAW) @ p + SHIFT) / SCALE), *p) for p in corners]
        write(pairs, '# model, other\n' + '\n'.join(lines) + '\n')
        r = c.run('align', '--points', pairs, '--out', out, '--json')
        check(r.returncode == OK, 'points: %d %s' % (r.returncode, r.stderr[-300:]))
        position, angle = errors(json.loads(r.stdout))
        check(position < 0.003 and angle < 0.03, 'by points: %.4f m, %.3f degrees' % (position, angle))
        r = c.run('align', '--points', pairs)
        check('point 4 is off by 0.00' in r.stdout and 'scale: 0.0254' in r.stdout, r.stdout)
        write(pairs, '\n'.join(lines[:3] + ['1 2 3']))
        r = c.run('align', '--points', pairs)
        check(r.returncode == INPUT and 'pairs.txt:4: six numbers' in r.stderr, r.stderr)
        write(pairs, '\n'.join(lines[:2]))
        r = c.run('align', '--points', pairs)
        check(r.returncode == INPUT and 'three pairs' in r.stderr, r.stderr)

        local = np.array([[0, 0, 0], [8, 0, 0], [8, 6, 0], [0, 6, 0], [8, 6, 2.6], [0, 0, 2.6]], float)
        far = np.array([691234.0, 5334567.0, 400.0])  # a model in UTM coordinates

        def written(first, second, *more):
            """Aligns by points; returns the exit code, the messages, and how far the written YAML is off."""
            write(pairs, '\n'.join('%.6f %.6f %.6f  %.6f %.6f %.6f' % (*a, *b) for a, b in zip(first, second)))
            r = c.run('align', '--points', pairs, '--out', out, *more)
            with open(out) as text:
                values = {line.split(':')[0].strip(): float(line.split(':')[1]) for line in text if line[0] == ' '}
            back = values['scale'] * first @ rotation_of(values).T + [values[k] for k in 'xyz']
            return r.returncode, r.stderr, np.linalg.norm(back - second, axis=1).max()
        code, words, off = written((turned(YAW) @ local.T).T + far, local, '--keep-scale')
        check(code == OK and off < 0.002, 'from UTM: %d %s %.4f m' % (code, words, off))
        wrong = local.copy()
        wrong[1, 0] += 1
        for name, first, second, more, expected in (
                ('a wrong point', local, wrong, (), 'without point 2 the others agree'),
                ('a wrong point of four', local[:4] , wrong[:4], (), 'only'),
                ('mirrored', local * [1, -1, 1], local, (), 'mirrored'),
                ('a plan with y down', local[:4] * [1, -1, 1], local[:4], (), 'upside down'),
                ('inches', local / 0.0254, local, ('--keep-scale',), 'when the scale is fitted')):
            code, words, _ = written(first, second, *more)
            check(code == INCOMPLETE and expected in words, '%s: %d %s' % (name, code, words))

        for status, words, arguments in (
                (USAGE, 'needs no recording', ('align', flight, '--points', pairs)),
                (INPUT, 'list of points', ('align', '--points', folder)),
                (USAGE, '--points', ('align', '--model', model)),
                (USAGE, '--model', ('align', flight)),
                (INPUT, 'nowhere.txt', ('align', flight, '--model', model, '--poses', 'nowhere.txt')),
                (INPUT, '/nowhere/', ('align', flight, '--model', model, '--poses', truth, '--out', '/nowhere/map.yaml'))):
            r = c.run(*arguments)
            check(r.returncode == status and words in r.stderr, '%s: %d %s' % (arguments, r.returncode, r.stderr))
    sys.exit(1 if failures else 0)


if __name__ == '__main__':
    main()
