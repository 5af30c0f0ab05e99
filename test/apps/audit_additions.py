#!/usr/bin/python3
"""`edge-mcl audit --add`: a chair that the model lacks is offered, and somebody who walks is not. The simulator knows the
truth.

usage: audit_additions.py EDGE_MCL SOURCE_DIRECTORY
"""
import json
import os
import sys
import tempfile

sys.dont_write_bytecode = True  # no .pyc of command_line.py in the source directory
from command_line import INPUT, OK, Cases, check, failures, write

CHAIR = 2.6, 3.4  # m
SCENARIO = '''model: %(maps)s/office.obj
camera: %(source)s/test/data/small_camera.yaml
rate: 10
path:
  - {time: 0, position: [1.0, 1.2, 1.3], yaw_deg: 50}
  - {time: 2.5, position: [2.0, 1.4, 1.4], yaw_deg: 70}
  - {time: 5, position: [2.6, 1.4, 1.4], yaw_deg: 90}
objects:
  - {name: chair, model: %(maps)s/objects/chair.obj, path: %(stands)s}
  - name: person
    model: %(maps)s/objects/person.obj
    path: [{time: 0, position: [1.4, 4.4, 0]}, {time: 5, position: [3.9, 4.6, 0]}]
'''


def audit(c, flight, *options):
    return c.run('audit', flight, '--no-mask', '--poses', os.path.join(flight, 'groundtruth.txt'), '--out',
                 os.path.join(c.folder, 'audit.csv'), '--json', *options)


def main():
    tool, source = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as folder:
        c = Cases(tool, folder)
        scenario, flight, added = (os.path.join(folder, name) for name in ('flight.yaml', 'flight', 'added.obj'))
        stands = '[{time: 0, position: [%s, %s, 0]}, {time: 5, position: [%s, %s, 0]}]' % (2 * CHAIR)
        write(scenario, SCENARIO % {'maps': os.path.join(source, 'maps'), 'source': source, 'stands': stands})
        r = c.run('simulate', scenario, flight)
        check(r.returncode == OK, 'simulate: ' + r.stderr)
        model = os.path.join(flight, 'model.obj')

        r = audit(c, flight, '--add', added, '--add-after', '2')
        check(r.returncode == OK, 'audit --add: ' + r.stderr)
        offered = json.loads(r.stdout)['offered']
        check(len(offered) == 1, 'only the chair is offered: %s' % offered)
        for k, truth in enumerate(CHAIR):
            middle = (offered[0]['lowest'][k] + offered[0]['highest'][k]) / 2
            check(abs(middle - truth) < 0.2, 'the chair is at %.2f: %s' % (truth, offered))
        check(offered[0]['stood_for_s'] > 2 and offered[0]['faces'] > 0, 'what the chair has: %s' % offered)

        number = offered[0]['number']
        r = c.run('inspect', model, '--objects', '--set', 'map.additions=' + added)
        check(r.returncode == OK and 'thing_%d_hiding_faces' % number in r.stdout, 'the map has the chair: ' + r.stdout)
        r = c.run('inspect', model, '--objects', '--set', 'map.additions=' + added, '--set', 'map.exclude=thing_%d_*' % number)
        check(r.returncode == OK and 'thing_' not in r.stdout, 'the chair is excluded: ' + r.stdout + r.stderr)
        r = c.run('localize', flight, '--no-mask', '--set', 'map.additions=' + added, '--json')
        check(r.returncode == OK and json.loads(r.stdout)['position_error_median_m'] < 0.02,
              'localize with additions: ' + r.stdout + r.stderr)

        r = audit(c, flight, '--add', added, '--set', 'map.additions= %s ' % added)
        check(r.returncode == INPUT and 'reads this file' in r.stderr and os.path.exists(added), 'overwritten: ' + r.stderr)

        precious = os.path.join(folder, 'notes.txt')
        write(precious, 'precious')
        for options, words in ((('--add', precious), 'not overwritten'), (('--add', model), 'not overwritten'),
                               (('--add', os.path.join(folder, 'x.obj'), '--obj', folder + '/./x.obj'), 'another result')):
            r = audit(c, flight, *options)
            check(r.returncode == INPUT and words in r.stderr, '%s: %s' % (options, r.stderr))
        check(os.path.exists(precious), 'a file of somebody else was removed')

        # What the map has is not offered again.
        r = audit(c, flight, '--add', os.path.join(folder, 'more.obj'), '--add-after', '2', '--set', 'map.additions=' + added)
        check(r.returncode == OK and not json.loads(r.stdout)['offered'], 'offered again: ' + r.stdout + r.stderr)

        # Nothing stood for a minute. A file of an earlier audit must not be taken for the result.
        markings = json.loads(r.stdout)['offered_markings']
        r = audit(c, flight, '--add', added, '--add-after', '60')
        summary = json.loads(r.stdout)
        check(r.returncode == OK and not summary['offered'] and summary['stood_too_short'] >= 1, 'after a minute: ' + r.stdout)
        check(os.path.exists(added) == (summary['offered_markings'] > 0), 'the old file: %d markings' % markings)

        os.remove(os.path.join(flight, 'depth.txt'))
        r = audit(c, flight, '--add', added)
        check(r.returncode == INPUT and 'no depth' in r.stderr and r.stderr.count('\n') == 1, 'without depth: ' + r.stderr)
    sys.exit(1 if failures else 0)


if __name__ == '__main__':
    main()
