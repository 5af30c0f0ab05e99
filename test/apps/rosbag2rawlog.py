#!/usr/bin/python3
"""Localizes a bag that rosbag2rawlog of Debian has converted: with images, range images, or both.

usage: rosbag2rawlog.py EDGE_MCL SOURCE_DIRECTORY

Exit code 77 (skipped) when rosbag2rawlog is missing or this build writes no bags.
"""
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile

IMAGE = """
  camera:
    type: CObservationImage
    image_topic: /camera/image_raw
    cameraInfo: /camera/camera_info
"""
DEPTH = """
  depth:
    type: CObservation3DRangeScan
    depth: /camera/depth/image_raw
    cameraInfo: /camera/depth/camera_info
"""
failures = []


def run(*command):
    return subprocess.run(command, capture_output=True, text=True)


def positions(file):
    with open(file) as f:
        return [[float(x) for x in line.split()][1:4] for line in f if line.strip() and line[0] != '#']


def main():
    tool, source = sys.argv[1:3]
    scenario = os.path.join(source, 'test/data/small_flight.yaml')
    camera = os.path.join(source, 'test/data/small_camera.yaml')
    with tempfile.TemporaryDirectory() as folder:
        def path(name):
            return os.path.join(folder, name)
        if not shutil.which('rosbag2rawlog') or run(tool, 'simulate', scenario, path('f.bag')).returncode:
            print('SKIPPED: rosbag2rawlog is missing, or this build writes no bags')
            return 77
        # The optical frame becomes the base of the robot. This is its ground truth. Since MRPT 2.14 rosbag2rawlog
        # must be asked for it, and it converts no depth images.
        is_old = '-f <world>' in run('rosbag2rawlog', '--help').stdout
        frames = ('-f', 'odom') if is_old else ('-b', 'camera_optical')
        run(tool, 'simulate', scenario, path('directory'))
        truth = positions(path('directory/groundtruth.txt'))
        # The converted file has no usable odometry. So depth alone drifts along bare walls.
        for name, limit, sensors, options in (
                ('images', 0.05, IMAGE, ['--camera', camera]),
                ('range images', 0.15, DEPTH, ['--set', 'likelihood.cues=depth']),
                ('both', 0.05, IMAGE + DEPTH, ['--camera', camera, '--depth'])):
            if sensors != IMAGE and not is_old:
                print('SKIPPED %s: this rosbag2rawlog converts no depth images' % name)
                continue
            with open(path('sensors.yml'), 'w') as f:
                f.write('sensors:' + sensors)
            converted = run('rosbag2rawlog', '-w', *frames, '-c', path('sensors.yml'), '-o',
                            path('f.rawlog'), path('f.bag'))
            r = run(tool, 'localize', path('f.rawlog'), '--model', os.path.join(source, 'maps/office.obj'),
                    '--initial-pose', '1.0,1.2,1.3,-90,0,-55', '--initial-std', '0.05,1', '--out',
                    path('out.txt'), *options)
            if converted.returncode != 0 or r.returncode not in (0, 4):
                print(converted.stderr[-500:], r.stderr[-500:])
                failures.append(name)
                continue
            estimate = positions(path('out.txt'))
            errors = [math.dist(a, b) for a, b in zip(estimate, truth)]
            good = len(estimate) == len(truth) and statistics.median(errors) < limit
            print('%s %s: %d of %d images, median error %.1f cm' % (
                'ok     ' if good else 'FAILED ', name, len(estimate), len(truth),
                100 * statistics.median(errors)))
            if not good:
                failures.append(name)
        r = run(tool, 'localize', path('f.rawlog'), '--model', os.path.join(source, 'maps/office.obj'),
                '--initial-pose', '1.0,1.2,1.3,-90,0,-55', '--out', path('out.txt'))
        if 'no calibration' not in r.stderr:
            failures.append('images without calibration are not said to be so')
    for failure in failures:
        print('FAILED:', failure)
    return 1 if failures else 0


if __name__ == '__main__':
    sys.exit(main())
