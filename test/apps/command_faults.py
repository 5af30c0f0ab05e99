#!/usr/bin/python3
"""Faults that the command line tool must report: options that contradict each other, outputs that
cannot be written, recordings of which a part is missing.

usage: command_faults.py EDGE_MCL SOURCE_DIRECTORY
"""
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # no .pyc of command_line.py in the source directory
from command_line import (INCOMPLETE, INPUT, OK, USAGE, Cases, add_mask, check, failures, make_sequence,
                          pgm, truncate_image, write)

ORIGIN = ('--initial-pose', '0,0,0,0,0,0', '--initial-std', '0.005,0.6', '--particles', '100')


def content(path):
    with open(path, 'rb') as f:
        return f.read()


def expect(c, name, status, words, *arguments):
    r = c.run(*arguments)
    check(r.returncode == status and all(w in r.stderr for w in words),
          '%s: %d (wanted %d) %s' % (name, r.returncode, status, r.stderr))
    return r


def sequence_in(c, name):
    path = os.path.join(c.folder, name)
    make_sequence(path)
    # Odometry and ground truth say that the camera is at rest.
    still = ''.join('%.2f 0 0 0 0 0 0 1\n' % (0.1 * i) for i in range(5))
    write(os.path.join(path, 'odometry.txt'), still)
    write(os.path.join(path, 'groundtruth.txt'), still)
    return path


def contradictions(c, source):
    sequence, office = sequence_in(c, 'options'), os.path.join(source, 'maps', 'office_flight.yaml')
    est, film, shot = (os.path.join(c.folder, name) for name in ('est.txt', 'film.mp4', 'shot'))
    trials = ('trials', office, '--count', '1')
    headless = ('view', sequence, '--headless', '--pictures', shot)
    for words, options in (
            (('--up', '--initial-std'), ('localize', sequence, '--up', '0,-1,0', '--initial-std', '0.1,3',
                                          '--out', est)),
            (('--global', '--initial-pose'), ('localize', 'x.bag', '--global', *ORIGIN[:2])),
            (('--up', '--initial-pose'), ('localize', 'x.bag', '--up', '0,-1,0', *ORIGIN[:2])),
            (('--images', '--headless'), ('view', sequence, '--images', '2')),
            (('--video', '--headless'), ('view', sequence, '--video', film)),
            (('--loop',), headless + ('--loop',)),
            (('--close-after',), headless + ('--close-after', '1')),
            (('--window-picture',), headless + ('--window-picture', shot + '.png')),
            (('--at', '--pictures'), ('view', sequence, '--headless', '--video', film, '--at', '1')),
            (('--video-rate', '--video'), headless + ('--video-rate', '5')),
            (('--soak', '--json'), ('bench', sequence, '--soak', '10', '--json')),
            (('--soak', '--table'), ('bench', sequence, '--soak', '10', '--table', '100')),
            (('--soak', '--dump-workload'), ('bench', sequence, '--soak', '10', '--dump-workload', film)),
            (('--soak', '--depth'), ('bench', sequence, '--soak', '10', '--depth')),
            (('--depth', '--table'), ('bench', sequence, '--depth', '--table', '100')),
            (('--depth', '--dump-workload'), ('bench', sequence, '--depth', '--dump-workload', film)),
            (('--images 20', '30'), trials + ('--kind', 'kidnap', '--images', '20')),
            (('--images 80', '130'), trials + ('--kind', 'blackout', '--images', '80')),
            (('--imu-sigma',), trials + ('--imu-sigma=-1',)),
            (('--blackout',), trials + ('--blackout=-1',)),
            (('--offset',), trials + ('--offset=-1',)),
            (('--angle',), trials + ('--angle=-1',)),
            (('--drift',), trials + ('--drift=-1',))):
        expect(c, ' '.join(words), USAGE, words, *options)
    check(not os.path.exists(film), 'nothing is written')


def rawlogs(c, source):
    sequence, rawlog = sequence_in(c, 'recorded'), os.path.join(c.folder, 'recorded.rawlog')
    call = ('rawlog', sequence, rawlog, '--base', 'optical')
    expect(c, 'a rawlog', OK, (), *call)
    before = content(rawlog)
    expect(c, 'an existing rawlog', INPUT, ('exists already',), *call)
    check(content(rawlog) == before and not os.path.exists(rawlog + '.part'), 'it is as it was')
    est = os.path.join(c.folder, 'recorded.txt')
    localize = ('localize', rawlog, '--model', os.path.join(sequence, 'model.obj'), '--out', est, *ORIGIN,
                '--set', 'tracking.min_visible_samples=0')  # a square has few samples
    r = expect(c, 'localize a rawlog', OK, (), *localize)
    check('of 5 images with truth' in r.stdout, 'the share is that of poses: ' + r.stdout)
    r = expect(c, 'localize a rawlog --json', OK, (), *localize, '--json')
    summary = json.loads(r.stdout)
    check(summary['images_with_truth'] == 5 and summary['within_10cm_3deg'] > 0.5, 'and as JSON')
    r = expect(c, 'a robot at rest', OK, (), *localize, '--set', 'tracking.update_min_d=0.1')
    check(' 0 not used' in r.stdout, 'has no images that are of no use: ' + r.stdout)
    expect(c, 'depth of a rawlog without', INPUT, ('depth asked for',), *localize, '--depth')
    with open(rawlog, 'r+b') as f:
        f.truncate(len(before) * 3 // 4)
    r = expect(c, 'a cut rawlog', INCOMPLETE, ('cut off after',), *localize)
    check(re.search('cut off after [1-4] images', r.stderr), 'and says where: ' + r.stderr)
    # A rawlog holds no depth images, so a broken list of them does no harm.
    write(os.path.join(sequence, 'depth.txt'), '0.00 depth/none.png\n')
    expect(c, 'a rawlog of a sequence with broken depth', OK, (), 'rawlog', sequence, rawlog + '2.rawlog')
    bag = os.path.join(c.folder, 'recorded.bag')
    os.remove(os.path.join(sequence, 'depth.txt'))
    r = c.run('bag', sequence, bag, '--base', 'optical')
    if r.returncode == INPUT and 'no ROS' in r.stderr:
        print('SKIPPED bags: this build has no ROS')
        return
    expect(c, 'depth of a bag without', INPUT, ('depth asked for',), 'localize', bag, '--depth', *localize[2:])


def outputs(c, source):
    sequence, est = sequence_in(c, 'outputs'), os.path.join(c.folder, 'outputs.txt')
    stats = os.path.join(c.folder, 'outputs.json')
    localize = ('localize', sequence, '--particles', '100', '--out', est)
    expect(c, 'a plot that is a directory', INPUT, ('cannot be written',), *localize, '--plot', c.folder)
    expect(c, 'statistics nowhere', INPUT, ('cannot be written',), *localize, '--stats', '/no/such/dir/x')
    check(not os.path.exists(est), 'said before the first image')
    expect(c, 'a plot of no format', INPUT, ('outputs.xyz',), *localize, '--stats', stats, '--plot',
           est.replace('.txt', '.xyz'))
    check(not os.path.exists(est) and not os.path.exists(stats), 'is said before the first image')
    strange = os.fsdecode(os.fsencode(c.folder) + b'/m\xff')
    shutil.copytree(sequence, strange)
    r = expect(c, 'a name that is not UTF-8', OK, (), 'localize', strange, *localize[2:], '--stats', stats,
               '--json')
    check(r.returncode == OK and json.loads(r.stdout)['images'] == 5, 'is no reason to lose anything')


def evaluation(c, source):
    est, reference = (os.path.join(c.folder, name) for name in ('few.txt', 'dense.txt'))
    write(est, ''.join('%.2f 0 0 0 0 0 0 1\n' % (0.1 * i) for i in range(10)))
    write(reference, ''.join('%.2f 0 0 0 0 0 0 1\n' % (100 + 0.01 * i) for i in range(100)))
    r = expect(c, 'poses of another time', INCOMPLETE, (), 'evaluate', est, reference)
    check(' 0 matched' in r.stdout and r.stdout.count('\n') == 1, 'have no errors: ' + r.stdout)
    r = expect(c, 'the same as JSON', INCOMPLETE, (), 'evaluate', est, reference, '--json')
    check(json.loads(r.stdout) == {'reference_poses': 100, 'matched': 0}, 'have none as JSON: ' + r.stdout)


def missing_images(c, source):
    sequence = sequence_in(c, 'basin')
    basin = ('basin', sequence, '--trials', '1', '--repeats', '1', '--particles', '50')
    expect(c, 'basin', OK, (), *basin)
    truncate_image(sequence)
    expect(c, 'basin without an image', INCOMPLETE, ('2.pgm',), *basin)
    add_mask(160, 120)(sequence)
    expect(c, 'masks of one image', INCOMPLETE, ('mask.txt: none for 4 of 5 images',), 'localize', sequence,
           '--particles', '50', '--out', os.path.join(c.folder, 'basin.txt'))


def simulation(c, source):
    flight = os.path.join(source, 'test', 'data', 'small_flight.yaml')
    mine = os.path.join(c.folder, 'mine')
    os.makedirs(mine)
    write(os.path.join(mine, 'model.obj'), '# mine\n')
    expect(c, 'a model in the way', INPUT, ('model.obj',), 'simulate', flight, mine, '--images', '1')
    check(content(os.path.join(mine, 'model.obj')) == b'# mine\n' and os.listdir(mine) == ['model.obj'],
          'it is as it was')
    out = os.path.join(c.folder, 'interrupted')
    listed = os.path.join(out, 'rgb.txt')
    with subprocess.Popen([c.tool, 'simulate', flight, out, '--rate', '200'], stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, text=True) as flying:
        while flying.poll() is None and not (os.path.exists(listed) and content(listed).count(b'\n') > 2):
            time.sleep(0.05)
        flying.send_signal(signal.SIGINT)
        stdout = flying.communicate()[0]
    check(flying.returncode == INCOMPLETE and '(interrupted)' in stdout,
          'an interrupted flight: %d %s' % (flying.returncode, stdout))


def comparison(c, source):
    def compare(out, *more):
        return ('compare', os.path.join(c.folder, out), '--rate', '3', '--seeds', '1', '--particles', '60',
                '--method', 'edges', *more)
    data = os.path.join(source, 'test', 'data')
    scenario, core = os.path.join(c.folder, 'edited.yaml'), str(min(os.sched_getaffinity(0)))
    with open(os.path.join(data, 'small_flight.yaml')) as f:
        text = f.read().replace('../../maps', os.path.join(source, 'maps'))
    text = text.replace('small_camera.yaml', os.path.join(data, 'small_camera.yaml'))
    write(scenario, text.replace('seed:', 'sead:'))
    expect(c, 'a scenario with a slip', INPUT, ('sead',), *compare('compared', '--flight', scenario))
    write(scenario, text)  # the mended scenario is not taken for another one
    flights = compare('compared', '--flight', scenario, '--budget-ms', '20', '--core', core)
    expect(c, 'compare', OK, (), *flights)
    made_by = content(os.path.join(c.folder, 'compared', 'comparison.md')).decode().splitlines()[4]
    check(all(' ' + w in made_by for w in ('--method edges', '--budget-ms 20', '--core ' + core)),
          'the command that makes the document anew: ' + made_by)
    expect(c, 'compare again', OK, (), *flights)
    with open(scenario) as f:
        text = f.read()
    assert 'seed: 3' in text
    write(scenario, text.replace('seed: 3', 'seed: 4'))
    expect(c, 'an edited scenario', INPUT, ('edited', 'another'), *flights)
    folders = [os.path.join(c.folder, parent, 'twin') for parent in ('one', 'two')]
    for folder in folders:
        shutil.copytree(os.path.join(c.folder, 'compared', 'flights', 'edited'), folder)
    expect(c, 'compare on a directory', OK, (), *compare('twins', '--sequence', folders[0]))
    expect(c, 'the same by another way', OK, (),
           *compare('twins', '--sequence', folders[1] + '/../../one/twin/'))
    expect(c, 'another of its name', INPUT, ('two/twin', 'another'),
           *compare('twins', '--sequence', folders[1]))


def detection(c, source):
    """`detect` must not overwrite its inputs. It reports inputs that it cannot read, and goes on."""
    def refused(name, words, *arguments):
        r = c.run('detect', *arguments)
        check(r.returncode == USAGE and all(w in r.stderr for w in words) and 'Traceback' not in r.stderr,
              'detect, %s: %d %s' % (name, r.returncode, r.stderr))
    folder = os.path.join(c.folder, 'detect')
    photos, more, out = (os.path.join(folder, name) for name in ('photos', 'more', 'out'))
    os.makedirs(photos)
    os.makedirs(more)
    # The kind of a picture file is recognized by its content.
    photo, same_stem, same_name = (os.path.join(photos, 'a.png'), os.path.join(photos, 'a.pgm'),
                                   os.path.join(more, 'a.png'))
    for path in (photo, same_stem, same_name):
        pgm(path, 0)
    before = content(photo)
    refused('pictures upon photographs', ['a.png', 'input'], photo, '--overlay', photos)
    refused('the same by another name', ['a.png', 'input'], photo, '--overlay', more + '/../photos')
    check(content(photo) == before, 'the photograph is as it was')
    for other in (same_stem, same_name):
        refused('two names alike', [photo, other], photo, other, '--out', out)
    refused('masks and pictures in one place', ['a.png'], photo, '--out', out, '--overlay', out + '/mask')
    check(not os.path.exists(out), 'nothing is begun')
    check(c.run('detect', photo, same_stem).returncode == OK, 'names alike, nothing to write')
    os.makedirs(out + '/mask.txt')
    r = c.run('detect', photo, '--out', out)
    check(r.returncode == INPUT and 'mask.txt' in r.stderr, 'a list that cannot be written: ' + r.stderr)
    strange = os.fsencode(photos) + b'/m\xff.png'
    shutil.copy(photo, strange)
    r = c.run('detect', os.fsdecode(strange), '--json')
    check(r.returncode == OK and len(json.loads(r.stdout)['images']) == 1, 'a name that is not UTF-8')

    sequence = os.path.join(folder, 'sequence')
    make_sequence(sequence)
    add_mask(160, 120)(sequence)
    masks = os.path.join(sequence, 'mask.txt')
    before = content(masks)
    refused("upon the sequence's own masks", ['mask.txt', 'input'], sequence, '--out', sequence)
    check(content(masks) == before, 'the list of masks is as it was')
    refused('a delay without a rate', ['--rate'], sequence, '--delay', '1')
    # The mask has 16 bits and small values, and covers the whole image. The detections do not.
    mask = os.path.join(sequence, 'mask', '0.pgm')
    with open(mask, 'wb') as f:
        f.write(b'P5\n160 120\n65535\n' + b'\0\1' * (160 * 120))
    r = c.run('detect', sequence, '--json')
    check(r.returncode == OK and json.loads(r.stdout)['summary']['mask_iou_mean'] < 1,
          'a mask of 16 bits: %d %s' % (r.returncode, r.stdout[:300]))
    for name, text in (('of another size', 'P5\n2 1\n255\n12'), ('that is none', '')):
        write(mask, text)
        r = c.run('detect', sequence, '--json')
        check(r.returncode == INCOMPLETE and '0.pgm' in r.stderr and r.stderr.count('\n') == 1,
              'a mask %s: %d %s' % (name, r.returncode, r.stderr))
    os.remove(masks)
    truncate_image(sequence)
    for options in ((), ('--rate', '5')):
        out = os.path.join(folder, 'masks%d' % len(options))
        r = c.run('detect', sequence, '--out', out, *options)
        lines = content(out + '/mask.txt').decode().splitlines()
        check(r.returncode == INCOMPLETE and '2.pgm' in r.stderr and len(lines) == 5,
              'four of five images: %d %s' % (r.returncode, r.stderr))


def devices(c, source):
    """A GPU that is asked for and is not there is an error in every command, not a CPU run."""
    if os.path.exists('/dev/nvidiactl'):
        print('SKIPPED: there is a GPU')
        return
    scenario = os.path.join(source, 'maps', 'office_flight.yaml')
    sequence = sequence_in(c, 'devices')
    for command in (('trials', scenario, '--count', '1', '--images', '2'), ('localize', sequence), ('basin', sequence)):
        expect(c, command[0] + ' --backend cuda', USAGE, ('likelihood.backend cuda',), *command, '--backend', 'cuda')


def national_coordinates(c, source):
    """A building that stands elsewhere has the same flight: its poses are moved, to 0.1 mm."""
    del source
    trajectories = []
    for name, (x, y, z), absolute in (('here', (0, 0, 0), True), ('there', (500000, 5400000, 200), True),
                                      ('relative', (500000, 5400000, 200), False)):
        sequence = sequence_in(c, name)
        corners = ''.join('v %.3f %.3f %.3f\n' % (x + a, y + b, z + 0.5)
                          for a, b in ((-.1, -.1), (.1, -.1), (.1, .1), (-.1, .1)))
        write(os.path.join(sequence, 'model.obj'), corners + 'f 1 2 3 4\n')
        start = (x, y, z) if absolute else (0, 0, 0)
        write(os.path.join(sequence, 'sequence.yaml'),
              'name: square\ninitial_pose: [%d, %d, %d, 0, 0, 0, 1]\ninitial_std: [0.005, 0.01]\n' % start)
        out = os.path.join(c.folder, name + '.txt')
        r = c.run('localize', sequence, '--out', out, '--particles', '100',
                  '--set', 'map.absolute_poses=%s' % str(absolute).lower())
        check(r.returncode == OK, 'national coordinates: %d %s' % (r.returncode, r.stderr))
        with open(out) as f:
            rows = [[float(v) for v in line.split()] for line in f if line[0] != '#']
        trajectories.append([[row[1] - start[0], row[2] - start[1], row[3] - start[2]] + row[4:] for row in rows])
    for other in trajectories[1:]:
        check(len(other) == len(trajectories[0]) == 5 and
              all(abs(a - b) < 1e-4 for p, q in zip(trajectories[0], other) for a, b in zip(p, q)),
              'national coordinates: other poses: %s, %s' % (trajectories[0], other))


def maps(c, source):
    out = os.path.join(c.folder, 'map.obj')
    sequence = sequence_in(c, 'no_depth')
    expect(c, 'map without depth', INPUT, ('depth',), 'map', sequence, '--out', out)
    os.remove(os.path.join(sequence, 'groundtruth.txt'))
    expect(c, 'map without poses', INPUT, ('--poses',), 'map', sequence, '--out', out)
    expect(c, 'map of nothing', INPUT, ('nothing.ply',), 'map', 'nothing.ply', '--out', out)
    office = os.path.join(source, 'maps', 'office.obj')
    expect(c, 'map into no folder', INPUT, ('/does/not',), 'map', office, '--out', '/does/not/exist.obj')
    lines = os.path.join(c.folder, 'line.obj')
    write(lines, 'v 0 0 0\nv 1 0 0\nl 1 2\n')
    expect(c, 'map of lines', INPUT, ('no faces',), 'map', lines, '--out', out)
    for wrong in (('--spacing', 'nan'), ('--spacing', '0'), ('--face-size', '-1'), ('--min-views', '-3')):
        expect(c, 'map with %s %s' % wrong, USAGE, (wrong[0], 'not a number from'), 'map', office, '--out', out, *wrong)
    for picture in ('x.gif', 'x.pbm', 'x.exr', 'x'):
        expect(c, 'map with ' + picture, INPUT, (picture + ': cannot',), 'map', 'missing.obj', '--out', out, '--picture', picture)
    empty = os.path.join(c.folder, 'empty.txt')
    write(empty, '# no pose\n')
    expect(c, 'map with empty poses', INPUT, ('empty.txt', 'no pose'), 'map', sequence, '--poses', empty, '--out', out)
    # A room of 5 m in millimetres. A wrong unit would take hours.
    scan = os.path.join(c.folder, 'scan.obj')
    write(scan, 'v 0 0 0\nv 5000 0 0\nv 5000 5000 2500\nf 1 2 3\n')
    expect(c, 'map of millimetres', INPUT, ('map.scale',), 'map', scan, '--out', out)
    cloud = os.path.join(c.folder, 'cloud.xyz')
    write(cloud, ''.join('%d %d %d\n' % (x, y, 0) for x in range(0, 5000, 100) for y in range(0, 5000, 100)))
    r = c.run('map', cloud, '--out', out)
    check(r.returncode == INPUT and 'map.scale' in r.stderr or 'Open3D' in r.stderr, 'cloud of millimetres: ' + r.stderr)
    check(not os.path.exists(out), 'a map that failed has left a file')
    with open('/dev/full', 'w') as full:
        r = subprocess.run([c.tool, 'inspect', office], stdout=full, stderr=subprocess.PIPE, universal_newlines=True)
    check(r.returncode == INPUT and 'standard output' in r.stderr, 'a full output: %d %s' % (r.returncode, r.stderr))


def audits(c, source):
    sequence, table = sequence_in(c, 'audited'), os.path.join(c.folder, 'audit.csv')
    picture, lines = os.path.join(c.folder, 'audit.png'), os.path.join(c.folder, 'audit.obj')
    r = expect(c, 'audit', OK, (), 'audit', sequence, '--poses', os.path.join(sequence, 'groundtruth.txt'), '--out', table,
               '--picture', picture, '--obj', lines, '--json')
    summary = json.loads(r.stdout)
    # The square has four sides of 0.2 m. All images are from one place, so nothing is judged.
    check(summary['images'] == 1 and summary['images_with_depth'] == 0 and
          abs(summary['length_m']['unseen'] - 0.8) < 1e-3 and not summary['gone_shapes'],
          'audit: summary %s' % summary)
    check(os.path.getsize(picture) > 1000, 'audit: no picture')
    expect(c, 'inspect the lines of an audit', OK, (), 'inspect', lines)
    expect(c, 'a confidence of 1', OK, (), 'inspect', os.path.join(sequence, 'model.obj'), '--set',
           'map.confidence=' + table)
    no_poses = os.path.join(c.folder, 'no_poses.txt')
    write(no_poses, '100 0 0 0 0 0 0 1\n')
    expect(c, 'audit without poses', INPUT, (no_poses,), 'audit', sequence, '--poses', no_poses, '--out', table)
    expect(c, 'audit into no folder', INPUT, ('/does/not',), 'audit', sequence, '--out', '/does/not/exist.csv')
    model = os.path.join(sequence, 'model.obj')
    expect(c, 'no table', INPUT, ('nothing.csv',), 'inspect', model, '--set', 'map.confidence=nothing.csv')
    with open(table, 'a') as f:
        f.write('line,0,0,0,1,1,1,0,3,1,0,nan,gone\n')
    expect(c, 'broken table', INPUT, ('audit.csv:6:',), 'inspect', model, '--set', 'map.confidence=' + table)
    with open(table, 'w') as f:
        f.write('part,x1,y1,z1,x2,y2,z2,shape,viewpoints,shown,by_chance,confidence,verdict\n'
                'shape,-0.1,-0.1,0.5,0.1,0.1,0.5,0,3,0,0,0,gone\n')
    expect(c, 'nothing is left of the model', INPUT, ('map.confidence',), 'inspect', model, '--set',
           'map.confidence=' + table)


def main():
    tool, source = sys.argv[1:3]
    folder = tempfile.mkdtemp()
    try:
        c = Cases(tool, folder)
        for part in (contradictions, rawlogs, outputs, evaluation, missing_images, simulation, comparison,
                     detection, devices, national_coordinates, maps,
                     audits):
            part(c, source)
    finally:
        shutil.rmtree(folder)
    return 1 if failures else 0


if __name__ == '__main__':
    sys.exit(main())
