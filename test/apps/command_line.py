#!/usr/bin/python3
"""The command line tool with good and bad input. Bad input gives one clear line and the right exit
code, and partial output is kept. The test makes its own sequence.

usage: command_line.py EDGE_MCL SOURCE_DIRECTORY
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time

failures = []
OK, USAGE, INPUT, INCOMPLETE = 0, 2, 3, 4


def check(good, text):
    print(('ok      ' if good else 'FAILED  ') + text)
    if not good:
        failures.append(text)


def write(path, text):
    with open(path, 'w') as f:
        f.write(text)


def pgm(path, shift):
    """Writes a bright square on dark ground: the model of make_sequence(), seen from 0.5 m."""
    width, height, rows = 160, 120, []
    for y in range(height):
        rows.append(bytes(190 if abs(x - 80 - shift) < 30 and abs(y - 60) < 30 else 60
                          for x in range(width)))
    with open(path, 'wb') as f:
        f.write(b'P5\n%d %d\n255\n' % (width, height) + b''.join(rows))


def make_sequence(folder):
    os.makedirs(os.path.join(folder, 'rgb'))
    for i in range(5):
        pgm(os.path.join(folder, 'rgb', '%d.pgm' % i), 0)
    write(os.path.join(folder, 'rgb.txt'),
          ''.join('%.2f rgb/%d.pgm\n' % (0.1 * i, i) for i in range(5)))
    write(os.path.join(folder, 'camera.yaml'),
          'image_width: 160\nimage_height: 120\ncamera_name: test\n'
          'camera_matrix: {rows: 3, cols: 3, data: [150, 0, 80, 0, 150, 60, 0, 0, 1]}\n'
          'distortion_model: plumb_bob\n'
          'distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n')
    write(os.path.join(folder, 'sequence.yaml'),
          'name: square\ninitial_pose: [0, 0, 0, 0, 0, 0, 1]\ninitial_std: [0.005, 0.01]\n')
    write(os.path.join(folder, 'model.obj'),
          'v -0.1 -0.1 0.5\nv 0.1 -0.1 0.5\nv 0.1 0.1 0.5\nv -0.1 0.1 0.5\nf 1 2 3 4\n')


class Cases:
    def __init__(self, tool, folder):
        self.tool, self.folder = tool, folder
        self.number = 0

    def run(self, *arguments):
        return subprocess.run([self.tool, *arguments], capture_output=True, text=True, timeout=120)

    def case(self, name, status, words, change=None, arguments=(), out=None, most_lines=1):
        """Localizes a new sequence that `change` has changed.

        It must end with `status` and lines that name `words`. @return number of poses written
        """
        self.number += 1
        sequence = os.path.join(self.folder, 'case%d' % self.number)
        make_sequence(sequence)
        if change:
            change(sequence)
        out = out or os.path.join(self.folder, 'est%d.txt' % self.number)
        # Four lines prove no pose, and a warning about it would come on top of the ones in question.
        r = self.run('localize', sequence, '--particles', '100', '--set', 'tracking.keep_probability=0.05',
                     '--out', out, *arguments)
        lines = [l for l in r.stderr.splitlines() if l.strip()]
        named = all(any(w in l for l in lines) for w in words)
        check(r.returncode == status and named and len(lines) <= most_lines,
              '%s: status %d (wanted %d), %s' % (name, r.returncode, status, lines or r.stdout))
        written = 0
        if os.path.exists(out):
            with open(out) as f:
                written = sum(1 for l in f if l[0] != '#')
        return written


def replace(name, old, new):
    def change(sequence):
        path = os.path.join(sequence, name)
        with open(path) as f:
            text = f.read()
        assert old in text
        write(path, text.replace(old, new))
    return change


def overwrite(name, text):
    return lambda sequence: write(os.path.join(sequence, name), text)


def remove(name):
    return lambda sequence: os.remove(os.path.join(sequence, name))


def truncate_image(sequence):
    with open(os.path.join(sequence, 'rgb', '2.pgm'), 'wb') as f:
        f.write(b'P5\n160 12')


def add_mask(width, height):
    def change(sequence):
        os.makedirs(os.path.join(sequence, 'mask'))
        with open(os.path.join(sequence, 'mask', '0.pgm'), 'wb') as f:
            f.write(b'P5\n%d %d\n255\n' % (width, height) + bytes(width * height))
        write(os.path.join(sequence, 'mask.txt'), '0.00 mask/0.pgm\n')
    return change


def bad_input(c):
    c.case('good sequence', OK, [])
    c.case('mask of the right size', OK, [], add_mask(160, 120))
    c.case('no model', INPUT, ['model'], remove('model.obj'))
    c.case('empty model', INPUT, ['model.obj'], overwrite('model.obj', ''))
    c.case('model without meaning', INPUT, ['model.obj'], overwrite('model.obj', 'hello\n'))
    c.case('NaN vertex', INPUT, ['model.obj'], replace('model.obj', 'v -0.1 -0.1', 'v nan -0.1'))
    c.case('absurd vertex', INPUT, ['vertex'], replace('model.obj', 'v -0.1 -0.1', 'v 1e20 -0.1'))
    c.case('camera without a key', INPUT, ['camera.yaml', 'image_width'],
           replace('camera.yaml', 'image_width', 'picture_width'))
    c.case('camera that is no YAML', INPUT, ['camera.yaml'], overwrite('camera.yaml', '{[:'))
    c.case('NaN initial pose', INPUT, ['initial_pose'],
           replace('sequence.yaml', '[0, 0, 0, 0', '[.nan, 0, 0, 0'))
    c.case('no initial pose', INPUT, ['initial_pose', '--global'],
           replace('sequence.yaml', 'initial_pose', 'another_pose'))
    c.case('no images listed', INPUT, ['rgb.txt'], overwrite('rgb.txt', '# none\n'))
    c.case('malformed list', INPUT, ['rgb.txt:1'], overwrite('rgb.txt', '0.1\n'))
    c.case('unknown parameter', USAGE, ['likelihood.sigma'], None, ['--set', 'likelihood.sigm=2'])
    c.case('illegal parameter', USAGE, ['likelihood.sigma', 'image.edge_share'], None,
           ['--set', 'likelihood.sigma=-1', '--set', 'image.edge_share=2'])
    c.case('unwritable output', INPUT, ['cannot be written'], out='/no/such/dir/x')
    # A faulty image in the middle is reported and skipped. Its pose is predicted and written.
    written = c.case('truncated image', INCOMPLETE, ['2.pgm'], truncate_image)
    check(written == 5, 'truncated image: %d of 5 poses written' % written)
    written = c.case('missing image', INCOMPLETE, ['3.pgm'], remove('rgb/3.pgm'))
    check(written == 5, 'missing image: %d of 5 poses written' % written)
    # A second line says that the other images have no mask.
    c.case('mask of another size', INCOMPLETE, ['16x12'], add_mask(16, 12), most_lines=2)
    written = c.case('time goes back', OK, ['time goes back'], replace('rgb.txt', '0.20', '0.05'))
    check(written == 4, 'time goes back: %d of 4 poses written' % written)
    c.case('nothing of the model in view', OK, ['nothing of the model'],
           replace('sequence.yaml', '[0, 0, 0, 0, 0, 0, 1]', '[0, 0, 0, 0, 1, 0, 0]'), most_lines=5)


def other_commands(c, source):
    sequence = os.path.join(c.folder, 'good')
    make_sequence(sequence)
    est = os.path.join(c.folder, 'est.txt')
    stats, plot = os.path.join(c.folder, 'stats.json'), os.path.join(c.folder, 'plot.png')
    r = c.run('localize', sequence, '--out', est, '--stats', stats, '--plot', plot,
              '--overlay', os.path.join(c.folder, 'overlay'), '--json')
    check(r.returncode == OK and json.loads(r.stdout)['images'] == 5, 'localize --json')
    with open(stats) as f:
        images = json.load(f)['images']
    check(len(images) == 5 and len(images[0]['covariance']) == 36, 'stats has every image')
    check(len(os.listdir(os.path.join(c.folder, 'overlay'))) == 5 and os.path.getsize(plot) > 1000,
          'overlays and plot are written')
    with open(est) as f:
        last = [float(x) for x in f.read().splitlines()[-1].split()]
    # The sides of the square fix the pose to a fraction of a pixel; 0.5 px are 1.7 mm here. Depth and
    # tilt are known less well.
    check(all(abs(x) < 0.02 for x in last[1:4]), 'pose of the square: %s' % last[1:4])
    r = c.run('evaluate', est, est, '--json')
    check(r.returncode == OK and json.loads(r.stdout)['success_share_of_matched'] == 1, 'evaluate with itself')
    r = c.run('evaluate', est, '/no/such/file')
    check(r.returncode == INPUT and '/no/such/file' in r.stderr, 'evaluate without reference')
    r = c.run('inspect', os.path.join(source, 'maps', 'cube_and_cylinder.obj'), '--json',
              '--picture', os.path.join(c.folder, 'model.png'))
    check(r.returncode == OK and json.loads(r.stdout)['edges']['contour'] == 48, 'inspect')
    rawlog = os.path.join(c.folder, 'x.rawlog')
    r = c.run('rawlog', sequence, rawlog)
    check(r.returncode == OK and os.path.getsize(rawlog) > 1000, 'rawlog')
    r = c.run('parameters')
    yaml = os.path.join(c.folder, 'all.yaml')
    write(yaml, r.stdout)
    again = c.run('parameters', '--params', yaml)
    check(again.stdout == r.stdout, 'parameters can be read back')
    for command in ('detect', 'localize', 'inspect', 'evaluate', 'basin', 'rawlog', 'simulate', 'bench',
                    'parameters', 'trials', 'view'):
        r = c.run(command, '--help')
        check(r.returncode == OK and len(r.stdout) > 200, command + ' --help')
    check(c.run().returncode == USAGE, 'no subcommand')
    check(c.run('localize').returncode == USAGE, 'no sequence')
    check(c.run('localize', '/no/such/dir').returncode == INPUT, 'no such sequence')


def viewer(c, source):
    sequence = os.path.join(c.folder, 'good')
    shot, film = os.path.join(c.folder, 'shot'), os.path.join(c.folder, 'film.mp4')
    r = c.run('view', sequence, '--headless', '--pictures', shot, '--video', film, '--particles', '100')
    check(r.returncode == OK and '5 moments' in r.stdout and os.path.exists(shot + '-1.png') and
          os.path.getsize(film) > 1000, 'view --headless: %s' % r.stderr)
    check(c.run('view', sequence, '--headless').returncode == USAGE, 'nothing to write')
    check(c.run('view', sequence, '--video', film).returncode == USAGE, 'a video without --headless')
    r = c.run('view', sequence, '--headless', '--pictures', shot, '--show', 'modelstyle=ghost')
    check(r.returncode == USAGE and 'model_style' in r.stderr, 'an unknown way to show it')
    r = c.run('view', sequence, '--headless', '--pictures', '/nonexistent/shot')
    check(r.returncode == INPUT and r.stderr.count('\n') == 1, 'a picture that cannot be written: %s' % r.stderr)
    check(c.run('view', '/no/such').returncode == INPUT, 'no such recording')
    rawlog = os.path.join(c.folder, 'good.rawlog')
    check(c.run('rawlog', sequence, rawlog).returncode == OK, 'rawlog')
    model = os.path.join(sequence, 'model.obj')
    r = c.run('localize', rawlog, '--model', model)
    check(r.returncode == INPUT and '--initial-pose' in r.stderr, 'a rawlog does not say where it begins')
    r = c.run('localize', os.path.join(sequence, 'rgb.txt') + '.rawlog', '--model', model)
    check(r.returncode == INPUT and r.stderr.count('\n') == 1, 'no such rawlog')


def parameter_document(c, source):
    r = c.run('parameters', '--markdown')
    with open(os.path.join(source, 'docs', 'parameters.md')) as f:
        check(r.returncode == OK and f.read() == r.stdout,
              'docs/parameters.md is what `edge-mcl parameters --markdown` prints')
    with open(os.path.join(source, 'docs', 'viewer.md')) as f:
        text = f.read()
    names = [line.split('`')[1] for line in r.stdout.split('## Viewer')[1].split('## Detector')[0].splitlines()
             if line.startswith('| `')]
    check(len(names) > 10 and all('`%s`' % n in text for n in names), 'viewer.md explains all: %s' % [
        n for n in names if '`%s`' % n not in text])


def search(c, source):
    office = os.path.join(source, 'maps', 'office_flight.yaml')
    r = c.run('trials', office, '--kind', 'teleport')
    check(r.returncode == USAGE and 'kidnap' in r.stderr, 'trials of an unknown kind')
    check(c.run('trials', '/no/such/file').returncode == INPUT, 'trials without a scenario')
    out = os.path.join(c.folder, 'trials.json')
    r = c.run('trials', office, '--kind', 'track', '--count', '1', '--images', '8', '--particles', '200',
              '--out', out, '--json')
    check(r.returncode == OK and json.loads(r.stdout)['flights'] == 1, 'trials --json')
    with open(out) as f:
        flight = json.load(f)['flights'][0]
    check(flight['tracking'] > 0 and flight['silent_failures'] == 0, 'a flight is tracked: %s' % flight)
    sequence = os.path.join(c.folder, 'good')
    r = c.run('localize', sequence, '--up', 'north', '--out', os.path.join(c.folder, 'est.txt'))
    check(r.returncode == USAGE and '--up' in r.stderr, 'localize --up north')
    # The camera stands still in front of a single square. This cannot tell one place from others.
    est, stats = os.path.join(c.folder, 'global.txt'), os.path.join(c.folder, 'global.json')
    r = c.run('localize', sequence, '--up', '0,-1,0', '--out', est, '--stats', stats,
              '--set', 'search.clearance=0', '--set', 'search.place_spacing=0.1')
    with open(stats) as f:
        states = json.load(f)['summary']['states']
    with open(est) as f:
        poses = [line for line in f if not line.startswith('#')]
    check(r.returncode == INCOMPLETE and 'no pose was found' in r.stderr, 'it says so: %d' % r.returncode)
    check(states == {'searching': 5} and not poses, 'no pose is made up: %s, %d' % (states, len(poses)))


def simulator(c, source):
    office = os.path.join(source, 'maps', 'office_flight.yaml')
    out = os.path.join(c.folder, 'flight')
    r = c.run('simulate', office, out, '--images', '3')
    check(r.returncode == OK and '3 images' in r.stdout, 'simulate')
    r = c.run('localize', out, '--particles', '200', '--out', os.path.join(c.folder, 'flight.txt'))
    check(r.returncode == OK and '3 images' in r.stdout, 'localize what was simulated')
    r = c.run('simulate', office, out)
    check(r.returncode == INPUT and 'holds a sequence already' in r.stderr, 'nothing is overwritten')
    broken = os.path.join(c.folder, 'broken.yaml')
    write(broken, 'model: x.obj\ncamera: y.yaml\nspeed: 3\n')
    r = c.run('simulate', broken, os.path.join(c.folder, 'none'))
    check(r.returncode == INPUT and "unknown key 'speed'" in r.stderr and
          r.stderr.count('\n') == 1, 'a broken scenario is one line')
    check(c.run('simulate', office).returncode == USAGE, 'no directory to write to')
    other = os.path.join(c.folder, 'other')
    check(c.run('simulate', office, other, '--seed', '1e3').returncode == USAGE and
          not os.path.exists(other), 'a seed is a whole number')
    with open(office) as f:
        text = f.read()
    write(broken, text[:text.index('objects:')].replace('model: ', 'model: %s/maps/' % source)
          .replace('camera: ', 'camera: %s/maps/' % source) + 'objects: {name: x}\n')
    r = c.run('simulate', broken, other)
    check(r.returncode == INPUT and 'objects: must be a list' in r.stderr, 'objects not in a list')


def detector(c, source):
    """Tests `detect`: masks of a flight that `localize` uses, pictures, wrong options."""
    flight = os.path.join(c.folder, 'masked_flight')
    r = c.run('simulate', os.path.join(source, 'test', 'data', 'small_flight.yaml'), flight,
              '--images', '12')
    check(r.returncode == OK, 'simulate a flight with a person')
    masks, pictures = os.path.join(c.folder, 'masks'), os.path.join(c.folder, 'masked_pictures')
    r = c.run('detect', flight, '--out', masks, '--overlay', pictures, '--rate', '5', '--delay', '0.1',
              '--json')
    check(r.returncode == OK, 'detect: ' + r.stderr)
    report = json.loads(r.stdout)
    # The flight has twelve images at 15 Hz. At 5 Hz the network runs on every third one.
    check(report['summary']['images'] == 12 and report['summary']['network_runs'] == 4,
          'the network keeps to its rate: %s' % report['summary'])
    check(0 <= report['summary']['mask_iou_mean'] <= 1, 'compared with the true masks')
    check(len(os.listdir(pictures)) == 12 and len(os.listdir(os.path.join(masks, 'mask'))) == 12,
          'a mask and a picture for every image')
    est = os.path.join(c.folder, 'masked.txt')
    small = ('--particles', '200', '--out', est)
    check(c.run('localize', flight, '--masks', masks, *small).returncode == OK, 'localize --masks')
    r = c.run('localize', flight, '--masks', c.folder, *small)
    check(r.returncode == INPUT and 'mask.txt' in r.stderr, 'no masks there')
    check(c.run('localize', flight, '--masks', masks, '--no-mask', *small).returncode == USAGE,
          'masks or none')
    used = os.path.join(c.folder, 'used_masks')
    r = c.run('localize', flight, '--masks', 'depth', '--masks-out', used, *small)
    check(r.returncode == OK and len(os.listdir(os.path.join(used, 'mask'))) == 12, 'masks by depth: ' + r.stderr)
    r = c.run('localize', flight, '--masks-out', flight, *small)
    check(r.returncode == USAGE and 'overwrite' in r.stderr, 'the masks of the flight are kept')
    os.rename(os.path.join(flight, 'depth.txt'), os.path.join(flight, 'no_depth.txt'))
    r = c.run('localize', flight, '--masks', 'depth', *small)
    check(r.returncode == INPUT and 'no depth.txt' in r.stderr, 'masks by depth need depth: ' + r.stderr)
    os.rename(os.path.join(flight, 'no_depth.txt'), os.path.join(flight, 'depth.txt'))
    photo = os.path.join(flight, 'rgb', sorted(os.listdir(os.path.join(flight, 'rgb')))[0])
    check(c.run('detect', photo, photo).returncode == OK, 'single images')
    check(c.run('detect', os.path.join(flight, 'rgb')).returncode == OK, 'a folder of images')
    for options, status, text in (((photo, '--rate', '2'), USAGE, '--rate'),
                                  ((photo, '--set', 'dilatoin=2'), USAGE, 'dilation'),
                                  ((photo, '--set', 'half_life=0'), USAGE, 'half_life'),
                                  ((photo, '--model', '/no/such.yaml'), INPUT, '/no/such.yaml'),
                                  (('/no/such.png',), INPUT, '/no/such.png'),
                                  ((c.folder + '/masks/mask.txt',), INPUT, 'mask.txt')):
        r = c.run('detect', *options)
        check(r.returncode == status and text in r.stderr, 'detect %s: %d %s' % (
            ' '.join(options), r.returncode, r.stderr))


def comparison(c, source):
    out = os.path.join(c.folder, 'comparison')
    flight = os.path.join(source, 'test', 'data', 'small_flight.yaml')
    call = ('compare', out, '--flight', flight, '--rate', '3', '--seeds', '1', '--particles', '60',
            '--method', 'edges', '--method', 'mrpt_2d', '--method', 'dead_reckoning')
    r = c.run(*call)
    check(r.returncode == OK, 'compare: ' + r.stderr)
    runs = sorted(os.listdir(os.path.join(out, 'runs')))
    # Two filters run with 60 and with 12 particles, and with the number that fits into the time, which
    # may take two runs to find. Dead reckoning runs once.
    check(5 <= len(runs) <= 9, 'every run is kept: %s' % runs)
    with open(os.path.join(out, 'comparison.md')) as report:
        text = report.read()
    check('edge_mcl, edges' in text and "MRPT's 2D filter" in text and 'dead reckoning' in text,
          'the document names what was compared')
    check(len(os.listdir(os.path.join(out, 'images'))) == 2, 'two plots')
    times = [os.stat(os.path.join(out, 'runs', name)).st_mtime_ns for name in runs]
    check(c.run(*call).returncode == OK, 'compare again')
    check(times == [os.stat(os.path.join(out, 'runs', name)).st_mtime_ns for name in runs],
          'what has been run is not run again')
    other_rate = [v if v != '3' else '4' for v in call]
    r = c.run(*other_rate)
    check(r.returncode == USAGE and '--rate' in r.stderr,
          'flights of another rate are not taken for these: ' + r.stderr)
    same = os.path.join(out, 'flights', 'small_flight')
    r = c.run(*(call + ('--sequence', same)))
    check(r.returncode == USAGE and 'small_flight' in r.stderr,
          'two sequences of one name are not taken for one: ' + r.stderr)
    write(os.path.join(out, 'runs', runs[0]), '{"half": ')
    r = c.run(*call)
    check(r.returncode == INPUT and runs[0] in r.stderr, 'a broken result is named: ' + r.stderr)
    for options, status, text in (((), USAGE, 'nothing to compare'),
                                  (('--flight', '/no/such.yaml'), INPUT, '/no/such.yaml'),
                                  (('--flight', flight, '--method', 'egdes'), USAGE, 'egdes'),
                                  (('--flight', flight, '--particles', '3'), USAGE, '--particles')):
        r = c.run('compare', os.path.join(c.folder, 'other'), *options)
        check(r.returncode == status and text in r.stderr, 'compare %s: %d %s' % (
            ' '.join(options), r.returncode, r.stderr))


def replaced_program(c, source):
    """When a library is built anew during a comparison, the methods must not be blamed for it."""
    libraries = os.path.join(c.folder, 'libraries')
    os.makedirs(libraries)
    name = 'libedge_mcl_core.so.0'
    linked = subprocess.run(['ldd', c.tool], check=True, capture_output=True, text=True).stdout
    original = next(line.split()[2] for line in linked.splitlines() if name in line)
    mine = os.path.join(libraries, name)
    os.symlink(original, mine)
    out = os.path.join(c.folder, 'replaced')
    runs = os.path.join(out, 'runs')
    call = [c.tool, 'compare', out, '--flight',
            os.path.join(source, 'test', 'data', 'small_flight.yaml'), '--rate', '3', '--seeds', '3',
            '--particles', '60', '--method', 'edges']
    environment = dict(os.environ, LD_LIBRARY_PATH=libraries)
    with subprocess.Popen(call, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                          text=True) as comparing:
        while comparing.poll() is None and not (os.path.isdir(runs) and os.listdir(runs)):
            time.sleep(0.02)
        os.remove(mine)
        write(mine, '')
        stderr = comparing.communicate()[1]
    check(comparing.returncode not in (OK, None) and 'cannot be started' in stderr,
          'runs that do not start end the comparison: %d %s' % (comparing.returncode, stderr))
    os.remove(mine)
    os.symlink(original, mine)
    check(subprocess.run(call, env=environment, capture_output=True).returncode == OK,
          'and it goes on from there')
    for name in os.listdir(runs):
        with open(os.path.join(runs, name)) as kept:
            check('exit code' not in kept.read(), 'it keeps none of them: ' + name)


def main():
    tool, source = sys.argv[1:3]
    folder = tempfile.mkdtemp()
    try:
        c = Cases(tool, folder)
        bad_input(c)
        other_commands(c, source)
        viewer(c, source)
        parameter_document(c, source)
        search(c, source)
        simulator(c, source)
        detector(c, source)
        comparison(c, source)
        replaced_program(c, source)
    finally:
        shutil.rmtree(folder)
    return 1 if failures else 0


if __name__ == '__main__':
    sys.exit(main())
