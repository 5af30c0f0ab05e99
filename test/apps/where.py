#!/usr/bin/python3
"""`edge-mcl where` and `edge-mcl image-trials`: answers for single images of a simulated flight, whose poses are known.

usage: where.py EDGE_MCL SOURCE_DIRECTORY
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
camera: %(maps)s/camera.yaml
rate: 10
mount_pitch_deg: 8
path:
  - {time: 0, position: [1.0, 1.2, 1.3], yaw_deg: 35}
  - {time: 0.2, position: [1.1, 1.2, 1.3], yaw_deg: 37}
'''


def rotation(q):
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def first_truth(flight):
    with open(os.path.join(flight, 'groundtruth.txt')) as lines:
        row = next(line.split() for line in lines if line[0] != '#')
    return np.array(row[1:4], float), rotation(np.array(row[4:8], float))


def answers(c, flight):
    photo = os.path.join(flight, 'rgb', sorted(os.listdir(os.path.join(flight, 'rgb')))[0])
    camera, model = (os.path.join(flight, name) for name in ('camera.yaml', 'model.obj'))
    base = ('where', photo, '--model', model, '--camera', camera)
    pictures = os.path.join(c.folder, 'answers')
    r = c.run(*base, '--json', '--pictures', pictures)
    check(r.returncode == OK, 'where: %d %s' % (r.returncode, r.stderr))
    answer = json.loads(r.stdout)[0]
    best = answer['poses'][0]
    position, turn = first_truth(flight)
    error = np.linalg.norm(np.array(best['position']) - position)
    angle = math.degrees(math.acos(min(1, (np.trace(turn.T @ rotation(best['quaternion_xyzw'])) - 1) / 2)))
    check(error < 0.05 and angle < 1, 'the first answer is off by %.2f m and %.1f degrees' % (error, angle))
    check(best['probability'] > 0.8, 'the first answer has a probability of %.2f' % best['probability'])
    check(abs(sum(p['probability'] for p in answer['poses']) + answer['none'] - 1) < 1e-6, 'the probabilities add up to one')
    # The path looks along yaw 35 and 8 degrees down.
    check(abs(best['heading_deg'] - 35) < 2 and abs(best['pitch_deg'] + 8) < 2, 'heading %.1f, pitch %.1f' % (best['heading_deg'], best['pitch_deg']))
    check(len(os.listdir(pictures)) == len(answer['poses']), 'pictures: %s' % os.listdir(pictures))
    again = json.loads(c.run(*base, '--json', '--set', 'search.store_places=false').stdout)[0]
    check(again['poses'] == answer['poses'], 'the answers are the same without stored places')

    r = c.run(*base, '--near', '8.5,1.5,1.5,1')
    check(r.returncode == INCOMPLETE and 'ambiguous' in r.stdout, 'elsewhere: %d %s' % (r.returncode, r.stdout))
    broken = os.path.join(c.folder, 'broken.png')
    write(broken, 'no picture')
    r = c.run('where', broken, photo, *base[2:])
    check(r.returncode == INCOMPLETE and 'broken.png' in r.stderr and os.path.basename(photo) in r.stdout,
          'one broken photograph of two: %d %s %s' % (r.returncode, r.stdout, r.stderr))
    for status, words, arguments in (
            (INPUT, 'broken.png', ('where', broken, *base[2:])),
            (INPUT, 'nowhere.png', ('where', 'nowhere.png', *base[2:])),
            (INPUT, 'nowhere.yaml', ('where', photo, '--model', model, '--camera', 'nowhere.yaml')),
            (USAGE, '--near', base + ('--near', '1,2,3')),
            (USAGE, '--near', base + ('--near', '1,2,3,nan')),
            (USAGE, '--near', base + ('--near', '1,2,3,0')),
            (USAGE, '--up', base + ('--up', '0,0,0')),
            (USAGE, '--sure', base + ('--sure', 'nan')),
            (USAGE, '--answers', base + ('--answers', '0'))):
        r = c.run(*arguments)
        check(r.returncode == status and words in r.stderr, '%s: %d %s' % (arguments[2:], r.returncode, r.stderr))


def trials(c, flight):
    out = os.path.join(c.folder, 'trials.json')
    r = c.run('image-trials', flight, '--every', '1', '--out', out)
    check(r.returncode == OK and 'first answer right 100' in r.stdout, 'image-trials: %d %s' % (r.returncode, r.stdout))
    with open(out) as answers_file:
        images = json.load(answers_file)['images']
    check(len(images) == 3 and all(i['rank'] == 1 for i in images), 'image-trials: every image has the right answer first')
    for i in images:  # the found pose is the right one, so it scores what the truth scores
        check(abs(i['poses'][0]['score'] - i['score_of_truth']) < 0.05 * i['score_of_truth'], 'score of the answer and of the truth')


def main():
    tool, source = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        c = Cases(tool, folder)
        scenario = os.path.join(folder, 'flight.yaml')
        write(scenario, SCENARIO % {'maps': os.path.join(source, 'maps')})
        flight = os.path.join(folder, 'flight')
        r = c.run('simulate', scenario, flight)
        check(r.returncode == OK, 'simulate: %d %s' % (r.returncode, r.stderr))
        answers(c, flight)
        trials(c, flight)
    sys.exit(1 if failures else 0)


if __name__ == '__main__':
    main()
